#include "sketch_comparison.hpp"

#include "example_models.hpp"
#include "thesis_row.hpp"

#include <algorithm>
#include <filesystem>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/render/render.hpp"
#include "batten/session/journal.hpp"
#include "batten/sketch/stroke.hpp"

namespace batten::experiments {

namespace {

/// The first model of a session as it is at the end; refused edits are told.
ExampleModel play(const std::filesystem::path& path, std::vector<std::string>& warnings) {
  const Session session = read_session(path.string());
  Document document;
  for (const SessionEdit& edit : session.edits) {
    try {
      document.apply(edit.edit);
    } catch (const RefusedEdit& refusal) {
      warnings.push_back(concat(path.string(), ":", edit.line, ": refused: ", refusal.what()));
    }
  }
  for (const ObjectId object : document.objects())
    if (document.object(object).kind() == ObjectKind::Model)
      return {path.stem().string(), document.model(object), {}};
  throw InvalidInput(concat(path.string(), ": there is no model of curves and faces in this session"));
}

/// Every model there is, by name: networks first, then sessions. They are made when they are asked for.
std::vector<std::pair<std::string, std::filesystem::path>> models_of(const std::string& folder) {
  std::vector<std::pair<std::string, std::filesystem::path>> models;
  for (const std::string& name : example_model_names()) models.emplace_back(name, "");
  std::vector<std::filesystem::path> sessions;
  if (!folder.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".jsonl") sessions.push_back(entry.path());
  std::sort(sessions.begin(), sessions.end());
  const auto& networks = example_model_names();
  for (const auto& path : sessions)
    if (std::find(networks.begin(), networks.end(), path.stem().string()) == networks.end())
      models.emplace_back(path.stem().string(), path);
  return models;
}

class ModelComparison {
 public:
  ModelComparison(const SketchComparisonOptions& options, const Progress& progress)
      : options_(options), progress_(progress) {
    ReportGrid& grid = result.grid;
    grid.title = "Surfaces of sketched models";
    grid.note = concat(
        "Deviation: distance from the truth over the diameter, mean by area. Normals: angle between quadrics "
        "fitted on "
        "either side of the smooth drawn curves, but for the ends of edges where a sharp curve begins or the "
        "curves do not lie in a plane; these count as corners, with the first and last piece in ",
        1 << options.surface.diffusion.splits,
        " of an edge. Sharp: the mean angle across sharp curves. Curvature: jump of the normal curvature "
        "across the smooth curves times the diameter. Faces: triangles measured. – : nothing to measure.");
    grid.columns = {"model",       "method",         "deviation mean, %",
                    "max, %",      "normals max",    "mean",
                    "corners max", "curvature mean", "max",
                    "sharp",       "faces",          "s",
                    "remark"};
  }

  void run(const ExampleModel& network) {
    ComparedModel entry{network.name, network.model.counts(), {}};
    for (const ModelSurfaceMethod method : options_.methods) {
      progress_.report(concat(network.name, " by ", word_of(method)), 0);
      entry.surfaces.push_back(measured(network, method));
    }
    result.models.push_back(std::move(entry));
  }

  SketchComparison result;

 private:
  MeasuredSurface measured(const ExampleModel& network, ModelSurfaceMethod method) {
    const PolylineMesh& model = network.model;
    ModelSurfaceOptions options = options_.surface;
    options.method = method;
    const std::string word(word_of(method));
    MeasuredSurface found;
    found.method = method;
    const auto refuse = [&](const std::string& reason) {
      std::vector<std::string> row(result.grid.columns.size());
      row[0] = network.name;
      row[1] = word;
      row.back() = concat("refused: ", reason);
      result.grid.rows.push_back(std::move(row));
      found.refusal = reason;
      return found;
    };
    ModelSurface surface;
    StageTimes clock;
    try {
      const ScopedStage timed(clock, word);
      surface = model_surface(model, options, progress_);
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      return refuse(error.what());
    }
    result.times.add(clock);
    const TriangleMesh& mesh = surface.mesh;
    if (!mesh.positions.allFinite()) return refuse("the surface has a vertex that is not a number");
    const double diameter = model.diameter();
    ModelContinuity continuity;
    {
      const ScopedStage timed(result.times, "continuity");
      continuity = model_continuity(model, mesh, options.diffusion.splits, progress_);
    }
    found.n_vertices = mesh.n_vertices();
    found.n_triangles = mesh.n_triangles();
    found.seconds = clock.total();
    found.diameter = diameter;
    std::vector<std::string> row = {network.name, word, "–", "–"};
    Eigen::VectorXd errors;
    if (network.truth) {
      errors.resize(mesh.n_vertices());
      for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
        errors[v] = network.truth(mesh.positions.row(v)) / diameter;
      const Eigen::VectorXd areas = lumped_mass(mesh.positions, mesh.triangles);
      const double mean = areas.dot(errors) / areas.sum();
      found.deviation = MeasuredSurface::Deviation{mean, errors.maxCoeff()};
      row[2] = number(100 * mean, "%.4f");
      row[3] = number(100 * errors.maxCoeff(), "%.3f");
    }
    const auto angle = [](const CurveContinuity& figures, double value) {
      return figures.n_samples > 0 ? number(degrees(value), "%.2f") + "°" : "–";
    };
    const CurveContinuity &smooth = continuity.smooth, &corners = continuity.corners,
                          &sharp = continuity.sharp;
    row.push_back(angle(smooth, smooth.max_normal_jump));
    row.push_back(angle(smooth, smooth.mean_normal_jump));
    row.push_back(angle(corners, corners.max_normal_jump));
    row.push_back(smooth.n_samples > 0 ? number(smooth.mean_curvature_jump * diameter, "%.3f") : "–");
    row.push_back(smooth.n_samples > 0 ? number(smooth.max_curvature_jump * diameter, "%.2f") : "–");
    row.push_back(angle(sharp, sharp.mean_normal_jump));
    row.push_back(concat(mesh.n_triangles()));
    row.push_back(number(clock.total(), "%.2f"));
    row.emplace_back(surface.warnings.empty() ? "" : surface.warnings.front());
    result.grid.rows.push_back(std::move(row));
    if (options_.pictures) draw(network, word, mesh, errors, continuity);
    surface.mesh = {};
    surface.cage = {};
    found.surface = std::move(surface);
    found.continuity = std::move(continuity);
    return found;
  }

  void draw(const ExampleModel& network, const std::string& method, const TriangleMesh& mesh,
            const Eigen::VectorXd& errors, const ModelContinuity& continuity) {
    const ScopedStage timed(result.times, "draw");
    Subject subject{.mesh = &mesh};
    std::vector<Shading> shadings = {Shading::Shaded, Shading::Isophotes};
    if (errors.size() > 0) {
      subject.errors = errors;
      subject.error_scale = 100;
      subject.error_unit = "% of the diameter";
      shadings.push_back(Shading::Error);
    }
    RenderOptions options;
    options.width = 360 * static_cast<int>(shadings.size());
    options.height = 330;
    std::string caption = concat(mesh.n_triangles(), " triangles.");
    if (continuity.smooth.n_samples > 0)
      caption += concat(" Normals jump by ", number(degrees(continuity.smooth.max_normal_jump), "%.2f"),
                        "° at most across smooth curves.");
    result.pictures.push_back({concat(network.name, " by ", method), caption,
                               encode_png(contact_sheet(subject, shadings, options, progress_)), false});
  }

  const SketchComparisonOptions& options_;
  const Progress& progress_;
};

}  // namespace

SketchComparison compare_sketch_surfaces(const std::string& folder, const SketchComparisonOptions& options,
                                         const Progress& progress) {
  const auto models = models_of(folder);
  for (const std::string& name : options.models)
    if (std::none_of(models.begin(), models.end(), [&](const auto& model) { return model.first == name; }))
      throw InvalidInput(
          concat("there is no network and no session called ", name,
                 folder.empty() ? "; name the folder of the session by --data" : concat(" in ", folder)));
  ModelComparison comparison(options, progress);
  for (const auto& [name, path] : models) {
    if (!options.models.empty() &&
        std::find(options.models.begin(), options.models.end(), name) == options.models.end())
      continue;
    comparison.run(path.empty() ? example_model(name) : play(path, comparison.result.warnings));
  }
  return std::move(comparison.result);
}

}  // namespace batten::experiments
