#include "thesis_h.hpp"

#include "thesis_h_definitions.hpp"
#include "thesis_h_tables.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/fairing/fair.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/operators/mesh_variation.hpp"
#include "batten/remeshing/measures.hpp"
#include "batten/remeshing/remesh.hpp"
#include "batten/render/render.hpp"
#include "batten/simplification/simplify.hpp"

namespace batten::experiments {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kNoiseSeed = 1;

std::string number(double value, const char* format = "%.3g") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// The numbers of vertices and faces of a mesh, for captions.
std::string counts(const TriangleMesh& mesh) {
  return concat(mesh.n_vertices(), " vertices, ", mesh.n_triangles(), " triangles.");
}

/// A mesh and the same with noise.
struct NoisyMesh {
  TriangleMesh clean, noisy;
  double clean_volume = 0;
};

class Experiments {
 public:
  /// @param tables how many will be made.
  Experiments(std::string folder, bool pictures, std::size_t tables, const Progress& progress)
      : folder_(std::move(folder)),
        pictures_(pictures),
        tables_(std::max<std::size_t>(tables, 1)),
        overall_(progress) {}

  void fairing();
  void remeshing();
  template <std::size_t n>
  void simplification(const char* number_of_table, const char* title, const SimplifyRow (&table)[n]);

  const ThesisTables& so_far() const { return result_; }
  ThesisTables take() { return std::move(result_); }

 private:
  /// Where the work is: before row `row` of `rows`.
  void begin_row(std::size_t row, std::size_t rows) {
    row_ = static_cast<double>(row) / static_cast<double>(rows);
  }
  void end_table(ReportGrid grid) {
    result_.grids.push_back(std::move(grid));
    ++table_;
    row_ = 0;
  }
  const TriangleMesh* mesh(const std::string& name);
  std::optional<NoisyMesh> noisy_mesh(const MeshData& data);
  Json faired(const std::string& mesh_name, const NoisyMesh& given, const std::string& algorithm,
              const FairingRow* thesis, FairingMethod method);
  void draw(const std::string& table, const std::string& mesh_name, const std::string& title,
            const std::string& caption, const TriangleMesh& mesh, Shading shading, double zoom = 1);
  /// Runs one case; false, with a warning, where the method refuses the mesh.
  template <typename Work>
  bool attempt(const std::string& stage, const std::string& what, Work&& work) {
    const ScopedStage timed(result_.times, stage);
    const double begin = (table_ + std::min(row_, 1.0)) / static_cast<double>(tables_);
    progress_ = overall_.part(what, begin, begin);
    progress_.report(what, 0);
    try {
      work();
      return true;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      result_.warnings.push_back(concat(what, ": ", error.what()));
      return false;
    }
  }

  std::string folder_;
  bool pictures_;
  std::size_t tables_;
  const Progress& overall_;
  Progress progress_;  ///< of the case at work
  int table_ = 0;      ///< number of the table at work
  double row_ = 0;     ///< share of its rows that are done
  ThesisTables result_;
  std::map<std::string, std::optional<TriangleMesh>> meshes_;
};

/// The mesh of a name of the thesis, or null where it is not at hand.
const TriangleMesh* Experiments::mesh(const std::string& name) {
  const auto known = meshes_.find(name);
  if (known != meshes_.end()) return known->second ? &*known->second : nullptr;
  // Files write the name in several ways: cube-hole, cube_hole, cubehole.
  std::vector<std::string> spellings = {name};
  for (const char* joint : {"_", ""}) {
    const std::size_t dash = name.find('-');
    if (dash != std::string::npos) spellings.push_back(name.substr(0, dash) + joint + name.substr(dash + 1));
  }
  std::optional<TriangleMesh>& found = meshes_[name];
  if (!folder_.empty())
    for (const char* inner : {"/", "/meshes/"})
      for (const std::string& spelling : spellings)
        for (const char* extension : {".ply", ".obj", ".off", ".stl"})
          for (const char* packed : {"", ".gz"}) {
            const std::string path = concat(folder_, inner, spelling, extension, packed);
            if (found || !std::filesystem::is_regular_file(path)) continue;
            const ScopedStage stage(result_.times, "read");
            found = read_mesh(path, &result_.warnings);
            result_.meshes[name] = {
                {"file", path}, {"vertices", found->n_vertices()}, {"faces", found->n_triangles()}};
          }
  if (!found) result_.missing.push_back(name);
  return found ? &*found : nullptr;
}

void Experiments::draw(const std::string& table, const std::string& mesh_name, const std::string& title,
                       const std::string& caption, const TriangleMesh& mesh, Shading shading, double zoom) {
  if (!pictures_ || mesh.n_triangles() == 0) return;
  const ScopedStage stage(result_.times, "draw");
  RenderOptions options;
  options.shading = shading;
  options.width = 560;
  options.height = 420;
  // Heads and animals of the public collections stand along y.
  if (mesh_name == "igea") options.view = {.azimuth_deg = 70, .elevation_deg = 10, .up_axis = 1};
  options.view.zoom = zoom;
  result_.pictures.push_back({concat("Table ", table, ", ", mesh_name, ": ", title), caption,
                              encode_png(render({.mesh = &mesh}, options, progress_)), false});
}

/// The mesh of a row of Table 2.1 with the thesis's noise; nothing where it is missing or refused.
std::optional<NoisyMesh> Experiments::noisy_mesh(const MeshData& data) {
  const TriangleMesh* given = mesh(data.mesh);
  if (given == nullptr) return std::nullopt;
  NoisyMesh made;
  made.clean = *given;
  // fandisk is at hand with a quarter of the thesis's triangles, from which one subdivision makes them.
  if (mesh_edges(made.clean.triangles, made.clean.n_vertices()).n_edges() + made.clean.n_vertices() ==
      data.n_vertices)
    made.clean = midpoint_subdivided(made.clean);
  made.noisy = made.clean;
  const auto make_noisy = [&] {
    made.noisy.positions = add_thesis_noise(made.clean.positions, made.clean.triangles, std::abs(data.c1),
                                            std::abs(data.c2), kNoiseSeed);
    made.clean_volume = enclosed_volume(made.clean.positions, made.clean.triangles);
  };
  if (!attempt("noise", concat("noise on ", data.mesh), make_noisy)) return std::nullopt;
  return made;
}

/// How far positions of the noisy mesh are from those without noise.
Json distance_from_clean(const NoisyMesh& given, const Points& positions) {
  const TriangleMesh& clean = given.clean;
  Json ours = Json::object();
  const double change = enclosed_volume(positions, clean.triangles) / given.clean_volume - 1;
  ours["volume_change_percent"] = std::isfinite(change) ? Json(100 * std::abs(change)) : Json(nullptr);
  ours["normal_error_deg"] = degrees(mean_normal_angle(clean.positions, positions, clean.triangles));
  return ours;
}

/// Adds a row to Table 2.2. @param thesis null where the thesis has none. @param ours null where we have
/// none.
void add_fairing_row(const std::string& mesh_name, const std::string& algorithm, const FairingRow* thesis,
                     const Json& ours, ReportGrid& grid, Json& json) {
  Json row = {{"mesh", mesh_name}, {"algorithm", algorithm}, {"thesis", nullptr}, {"ours", ours}};
  std::vector<std::string> cells = {mesh_name, algorithm, "", "", "", "", "", "", "", ""};
  if (thesis != nullptr) {
    row["thesis"] = {{"time_step", thesis->time_step},
                     {"iterations", thesis->iterations},
                     {"volume_change", thesis->volume_change}};
    cells[2] = number(thesis->time_step);
    cells[4] = concat(thesis->iterations);
    cells[6] = number(thesis->volume_change);
    if (thesis->similarity > 0) {
      row["thesis"]["similarity"] = thesis->similarity;
      cells[8] = number(thesis->similarity);
    }
  }
  if (!ours.is_null()) {
    if (ours.contains("time_step") && !ours["time_step"].is_null())
      cells[3] = number(ours["time_step"].get<double>());
    if (ours.contains("iterations")) cells[5] = concat(ours["iterations"].get<int>());
    if (!ours["volume_change_percent"].is_null())
      cells[7] = number(ours["volume_change_percent"].get<double>(), "%.4f");
    cells[9] = number(ours["normal_error_deg"].get<double>(), "%.2f") + "°";
  }
  grid.rows.push_back(std::move(cells));
  json.push_back(std::move(row));
}

/// The figures of one algorithm; null where it refuses the mesh.
Json Experiments::faired(const std::string& mesh_name, const NoisyMesh& given, const std::string& algorithm,
                         const FairingRow* thesis, FairingMethod method) {
  Json ours;
  attempt("fair", concat("fairing ", mesh_name, " by ", algorithm), [&] {
    FairingOptions options;
    options.method = method;
    if (thesis != nullptr) options.iterations = thesis->iterations;
    const FairingResult result = fair(given.noisy.positions, given.noisy.triangles, options, progress_);
    TriangleMesh smooth = given.noisy;
    smooth.positions = result.positions;
    ours = distance_from_clean(given, result.positions);
    ours["iterations"] = result.iterations;
    ours["time_step"] = result.time_step > 0 ? Json(result.time_step) : Json(nullptr);
    draw("2.2", mesh_name, algorithm,
         concat("Normals off by ", number(ours["normal_error_deg"].get<double>()), "°."), smooth,
         Shading::Shaded);
  });
  return ours;
}

void Experiments::fairing() {
  ReportGrid grid;
  grid.title = "Table 2.2: fairing";
  grid.note =
      "H: as printed. ΔV: difference of the volume from that of the mesh without noise; ours in per cent of "
      "it "
      "(the printed ones, whatever their unit, are none). Normals: mean angle "
      "between the triangles of the result and those without noise, the noisy mesh first. Noise by (2.36) "
      "with the bounds of Table 2.1, in mean edge lengths. σ is 0.6. auto is the default of batten fair.";
  grid.columns = {"mesh",       "algorithm", "τ (H)",      "τ ours", "steps (H)",
                  "steps ours", "ΔV (H)",    "ΔV ours, %", "σ (H)",  "normals ours"};
  Json& json = result_.tables["2.2"] = Json::array();
  std::size_t n_rows = 0;
  for (const MeshData& data : kTable21) {
    begin_row(n_rows++, std::size(kTable21));
    const std::optional<NoisyMesh> given = noisy_mesh(data);
    const auto add = [&](const std::string& algorithm, const FairingRow* thesis, const Json& ours) {
      add_fairing_row(data.mesh, algorithm, thesis, ours, grid, json);
    };
    if (given) {
      draw("2.2", data.mesh, "without noise", counts(given->clean), given->clean, Shading::Shaded);
      draw("2.2", data.mesh, "with noise", "", given->noisy, Shading::Shaded);
      add("noisy", nullptr, distance_from_clean(*given, given->noisy.positions));
    }
    for (const FairingRow& row : kTable22) {
      if (std::string(row.mesh) != data.mesh) continue;
      const std::string algorithm = row.algorithm;
      const FairingMethod method = algorithm == "MCF"   ? FairingMethod::MeanCurvature
                                   : algorithm == "SDF" ? FairingMethod::SurfaceDiffusion
                                                        : FairingMethod::NonlocalSurfaceDiffusion;
      add(algorithm, &row, given ? faired(data.mesh, *given, algorithm, &row, method) : Json());
    }
    if (given) add("auto", nullptr, faired(data.mesh, *given, "auto", nullptr, FairingMethod::Automatic));
  }
  end_table(std::move(grid));
}

void Experiments::remeshing() {
  ReportGrid grid;
  grid.title = "Table 2.3: remeshing";
  grid.note =
      "Each figure: H / ours / ours as H defines it, where that differs. Changes in per cent; ours with "
      "areas "
      "and edges over their means, and without "
      "borders and kept edges in ΔH and ΔVar(H); as H defines it, with them, and in the unit of the mesh. "
      "d_h: mean distance of the original's vertices from the "
      "result, ours over the diameter. Smallest angle: mean over the triangles; normals: mean angle by area.";
  grid.columns = {"mesh",    "method", "rounds",         "ΔH",     "ΔVar(E)", "ΔVar(A)",
                  "ΔVar(H)", "d_h",    "smallest angle", "normals"};
  Json& json = result_.tables["2.3"] = Json::array();
  std::string drawn;
  std::size_t n_rows = 0;
  for (const RemeshRow& row : kTable23) {
    begin_row(n_rows++, std::size(kTable23));
    const TriangleMesh* original = mesh(row.mesh);
    // Enlarged until triangles can be told apart.
    const double zoom =
        original == nullptr ? 1 : std::max(1.0, std::round(std::sqrt(original->n_triangles() / 6000.0)));
    const std::string enlarged = zoom > 1 ? concat(" Enlarged ", zoom, " times.") : std::string();
    if (original != nullptr && drawn != row.mesh)
      draw("2.3", row.mesh, "original", counts(*original) + enlarged, *original, Shading::Wireframe, zoom);
    drawn = row.mesh;
    Json ours;
    if (original != nullptr)
      attempt("remesh", concat("remeshing ", row.mesh, " by ", row.method), [&] {
        RemeshOptions options;
        options.method =
            std::string(row.method) == "LF" ? RemeshMethod::LaplacianFlow : RemeshMethod::Adaptive;
        options.max_iterations = row.iterations;
        const RemeshResult made = remesh(*original, options, progress_);
        const RemeshMeasures measures = remesh_measures(*original, made.mesh, options.keep_edges, progress_);
        const MeshVariation as_printed =
            mesh_variation(original->positions, original->triangles, made.mesh.positions, made.mesh.triangles,
                           {}, progress_);
        const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
        const MeshQuality quality = mesh_quality(made.mesh.positions, made.mesh.triangles);
        ours = {{"iterations", made.report.iterations},
                {"vertices", made.mesh.n_vertices()},
                {"curvature_change", measures.curvature_change},
                {"edge_variance_change", measures.edge_variance_change},
                {"area_variance_change", measures.area_variance_change},
                {"curvature_variance_change", measures.curvature_variance_change},
                {"mean_distance", measures.mean_distance},
                {"as_h_defines_it",
                 {{"curvature_change", known(as_printed.mean_curvature)},
                  {"edge_variance_change", known(as_printed.edge_variance)},
                  {"area_variance_change", known(printed_area_variance(*original, made.mesh))},
                  {"curvature_variance_change", known(as_printed.curvature_variance)}}},
                {"mean_smallest_angle_deg", degrees(quality.mean_min_angle)},
                {"normal_error_deg", degrees(measures.normal_error)}};
        draw("2.3", row.mesh, row.method, counts(made.mesh) + enlarged, made.mesh, Shading::Wireframe, zoom);
      });
    const auto cell = [&](double thesis, const char* key, double scale, const char* format) {
      std::string text =
          concat(thesis, " / ", ours.is_null() ? "–" : number(scale * ours[key].get<double>(), format));
      if (ours.is_null() || !ours["as_h_defines_it"].contains(key)) return text;
      const Json& printed = ours["as_h_defines_it"][key];
      return text + " / " + (printed.is_null() ? "–" : number(scale * printed.get<double>(), format));
    };
    grid.rows.push_back(
        {row.mesh, row.method,
         concat(row.iterations, " / ", ours.is_null() ? "–" : concat(ours["iterations"].get<int>())),
         cell(row.curvature, "curvature_change", 100, "%.1f"),
         cell(row.edges, "edge_variance_change", 100, "%.1f"),
         cell(row.areas, "area_variance_change", 100, "%.1f"),
         cell(row.curvature_variance, "curvature_variance_change", 100, "%.1f"),
         cell(row.distance, "mean_distance", 1, "%.1e"),
         ours.is_null() ? "" : number(ours["mean_smallest_angle_deg"].get<double>(), "%.1f") + "°",
         ours.is_null() ? "" : number(ours["normal_error_deg"].get<double>(), "%.2f") + "°"});
    json.push_back({{"mesh", row.mesh},
                    {"method", row.method},
                    {"thesis",
                     {{"iterations", row.iterations},
                      {"curvature_change", row.curvature / 100},
                      {"edge_variance_change", row.edges / 100},
                      {"area_variance_change", row.areas / 100},
                      {"curvature_variance_change", row.curvature_variance / 100},
                      {"mean_distance", row.distance}}},
                    {"ours", ours}});
  }
  end_table(std::move(grid));
}

template <std::size_t n>
void Experiments::simplification(const char* number_of_table, const char* title,
                                 const SimplifyRow (&table)[n]) {
  constexpr const char* kNames[] = {"dmax", "dmean", "drms"};
  ReportGrid grid;
  grid.title = concat("Table ", number_of_table, ": ", title);
  grid.note =
      "Distances of the original's vertices from the result (2.102–2.104). H and MeshLab: as printed by H, "
      "in "
      "the unit of its mesh; behind it over the diameter, where Table 2.1 gives the volume and so the size. "
      "Ours: over the diameter. Back: the largest distance of the result from the original. Default: batten "
      "simplify; p-Laplacian: its --method plaplacian, the thesis's.";
  grid.columns = {"mesh", "removed, %", "by", "dmax", "dmean", "dRMS", "back", "smallest angle", "faces"};
  Json& json = result_.tables[number_of_table] = Json::array();
  std::string drawn;
  std::size_t n_rows = 0;
  for (const SimplifyRow& row : table) {
    begin_row(n_rows++, n);
    const TriangleMesh* original = mesh(row.mesh);
    const double diameter = original == nullptr ? 0 : bounding_box_diagonal(original->positions);
    const double diameter_of_thesis = original == nullptr ? 0 : printed_diameter(row.mesh, *original);
    const auto add_printed = [&](const char* by, const double(&figures)[3]) {
      std::vector<std::string> cells = {row.mesh, number(row.removed), by};
      Json printed = Json::object();
      for (int k = 0; k < 3; ++k) {
        printed[kNames[k]] = figures[k];
        cells.push_back(concat(number(figures[k], "%.6f")));
        if (diameter_of_thesis > 0) {
          printed["relative"][kNames[k]] = figures[k] / diameter_of_thesis;
          cells.back() += concat(" (", number(figures[k] / diameter_of_thesis, "%.1e"), ")");
        }
      }
      grid.rows.push_back(std::move(cells));
      return printed;
    };
    Json entry = {{"mesh", row.mesh}, {"removed_percent", row.removed}};
    entry["meshlab"] = add_printed("MeshLab (H)", row.meshlab);
    entry["thesis"] = add_printed("H", row.thesis);
    if (original != nullptr && drawn != row.mesh)
      draw(number_of_table, row.mesh, "original", counts(*original), *original, Shading::Wireframe);
    drawn = row.mesh;
    const auto run = [&](const char* key, const char* by, SimplifyMethod method) {
      Json& ours = entry[key] = nullptr;
      if (original == nullptr) return;
      attempt("simplify", concat("simplifying ", row.mesh, " by ", row.removed, " %"), [&] {
        SimplifyOptions options;
        options.method = method;
        options.remove = row.removed / 100;
        const SimplifyResult made = simplify(*original, options, progress_);
        if (!made.reached)
          result_.warnings.push_back(concat(row.mesh, ": no more than ",
                                            original->n_triangles() - made.mesh.n_triangles(), " of ",
                                            original->n_triangles(), " faces could be removed"));
        const Comparison comparison = compare({original->positions, original->triangles, {}},
                                              {made.mesh.positions, made.mesh.triangles, {}}, {}, progress_);
        const MeshQuality quality = mesh_quality(made.mesh.positions, made.mesh.triangles);
        const DistanceFigures& figures = comparison.a_to_b.vertices;
        const double back = std::max(comparison.b_to_a.vertices.max, comparison.b_to_a.samples.max);
        ours = {{"dmax", figures.max / diameter},
                {"dmean", figures.mean / diameter},
                {"drms", figures.rms / diameter},
                {"back_dmax", back / diameter},
                {"mean_min_angle_deg", degrees(quality.mean_min_angle)},
                {"faces", made.mesh.n_triangles()}};
        grid.rows.push_back({row.mesh, number(row.removed), by, number(figures.max / diameter, "%.1e"),
                             number(figures.mean / diameter, "%.1e"), number(figures.rms / diameter, "%.1e"),
                             number(back / diameter, "%.1e"),
                             number(degrees(quality.mean_min_angle), "%.1f") + "°",
                             concat(made.mesh.n_triangles())});
        draw(number_of_table, row.mesh, concat(number(row.removed), " % removed, ", by), counts(made.mesh),
             made.mesh, Shading::Wireframe);
      });
    };
    run("plaplacian", "p-Laplacian", SimplifyMethod::PLaplacian);
    run("ours", "default", SimplifyMethod::Quadric);
    json.push_back(std::move(entry));
  }
  end_table(std::move(grid));
}

}  // namespace

const std::vector<std::string>& thesis_h_tables() {
  static const std::vector<std::string> tables = {"2.2", "2.3", "2.4", "2.5"};
  return tables;
}

ThesisTables thesis_h(const std::string& folder, const std::vector<std::string>& tables, bool pictures,
                      const Progress& progress, const TableDone& done) {
  Experiments experiments(folder, pictures, tables.size(), progress);
  for (const std::string& table : thesis_h_tables()) {
    if (std::find(tables.begin(), tables.end(), table) == tables.end()) continue;
    if (table == "2.2") experiments.fairing();
    if (table == "2.3") experiments.remeshing();
    if (table == "2.4") experiments.simplification("2.4", "simplification of meshes with edges", kTable24);
    if (table == "2.5") experiments.simplification("2.5", "simplification of large meshes", kTable25);
    if (done) done(experiments.so_far());
  }
  return experiments.take();
}

}  // namespace batten::experiments
