#include "command.hpp"
#include "commands/check.hpp"
#include "model_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/pipeline/checked_curves.hpp"
#include "batten/render/render.hpp"

namespace batten::cli {

namespace {

/// Of the picture of a failure, as a share of the diameter of the surface.
constexpr double kPictureRadius = 0.12;
/// Tangent of the angle between the view and the normal.
constexpr double kObliqueness = 0.7;
/// About so many across the picture.
constexpr double kStripes = 10;

struct CheckArguments : commands::CheckArguments {
  std::string surface, network, pictures;
};

/// Isophotes around the worst place of a curve, with the curve upon them: seen from the side of the curve,
/// not along the normal, around which isophotes are few, and so many that some ten of them cross the picture.
Image picture_of(const TriangleMesh& mesh, const CurveNetwork& network, int c, const CurveCheck& check,
                 const Progress& progress) {
  const Surroundings there =
      surroundings(mesh, network, c, check.curves[at(c)].worst, kPictureRadius * check.diameter);
  Eigen::Vector3d direction = there.normal;
  if (!there.network.curves.empty()) {
    const std::vector<int>& vertices = there.network.curves.front().vertices;
    const Eigen::Vector3d along =
        network.positions.row(vertices.back()) - network.positions.row(vertices.front());
    direction += kObliqueness * there.normal.cross(along).stableNormalized();
  }
  direction.normalize();
  Subject subject;
  subject.mesh = &there.mesh;
  if (!there.network.curves.empty()) subject.network = &there.network;
  RenderOptions options;
  options.shading = Shading::Isophotes;
  options.stripes = static_cast<int>(std::clamp(kStripes * kPi / (4 * there.spread + 1e-9), 28.0, 1000.0));
  options.view.azimuth_deg = degrees(std::atan2(direction.y(), direction.x()));
  options.view.elevation_deg = degrees(std::asin(std::clamp(direction.z(), -1.0, 1.0)));
  options.view.perspective = false;
  options.width = options.height = 800;
  return render(subject, options, progress);
}

void write_pictures(const std::string& folder, const TriangleMesh& mesh, const CurveNetwork& network,
                    const CurveCheck& check, Outcome& outcome, const Progress& progress) {
  const ScopedStage stage(outcome.times, "pictures");
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) throw FileError(folder, 0, concat("the folder cannot be made: ", problem.message()));
  Json& list = outcome.figures["pictures"] = Json::array();
  for (std::size_t c = 0; c < check.curves.size(); ++c) {
    if (check.curves[c].verdict != CurveVerdict::Fail) continue;
    const std::string path = (std::filesystem::path(folder) / concat("curve_", c, ".png")).string();
    write_file(path, encode_png(picture_of(mesh, network, static_cast<int>(c), check, progress)));
    list.push_back(path);
  }
  outcome.lines.push_back(
      concat("wrote ", list.size(), list.size() == 1 ? " picture" : " pictures", " to ", folder));
}

Outcome run_check(const CheckArguments& arguments, Context& context) {
  Outcome outcome;
  Model surface, network;
  {
    const ScopedStage stage(outcome.times, "read");
    surface = read_model(arguments.surface, outcome.warnings);
    network = read_model(arguments.network, outcome.warnings);
  }
  if (!surface.mesh)
    throw InvalidInput(concat(surface.path, " is a network; `batten surface ", surface.path,
                              " -o surface.ply` makes the surface to check"));
  if (!network.network)
    throw InvalidInput(concat("--network takes a network, but ", network.path, " is a mesh"));
  const CurveCheck check =
      check_curves(*surface.mesh, *network.network, options_of(arguments), context.progress);
  add_run(check.times, {}, outcome);

  Json& figures = outcome.figures;
  figures["surface"] = describe(surface);
  figures["network"] = describe(network);
  commands::append(commands::figures_of(check), figures);
  for (const CheckedCurve& curve : check.curves) {
    std::string line = concat("  ", word_of(curve.verdict), "  ", curve.name);
    if (curve.figures.n_samples > 0)
      line += concat(": normals differ by ", degrees(curve.figures.max_normal_jump), " degrees at most, ",
                     degrees(curve.figures.mean_normal_jump), " in the mean");
    for (const std::string& reason : curve.reasons) line += "; " + reason;
    if (curve.verdict == CurveVerdict::Fail)
      line += concat("; worst at (", curve.worst.x(), ", ", curve.worst.y(), ", ", curve.worst.z(), ")");
    outcome.lines.push_back(std::move(line));
  }
  if (!arguments.pictures.empty())
    write_pictures(arguments.pictures, *surface.mesh, *network.network, check, outcome, context.progress);
  if (check.n_checked == 0)
    outcome.failure = concat("nothing was checked: ", network.path, " has borders alone on ", surface.path);
  else if (!check.passes())
    outcome.failure =
        concat(check.n_failed, " of ", check.n_checked, " curves of ", network.path, " fail on ",
               surface.path, arguments.pictures.empty() ? "; --pictures FOLDER shows where" : "");
  return outcome;
}

}  // namespace

void add_check(CLI::App& app) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* command =
      add_command(app, "check", "Say of every curve of a network whether a surface is smooth across it.",
                  "batten check surface.ply --network net.json --tolerance 0.5deg --pictures failures",
                  [arguments](Context& context) { return run_check(*arguments, context); });
  command->add_option("SURFACE", arguments->surface, "Mesh to check")->required();
  command->add_option("--network", arguments->network, "Curves to check it along")->required();
  command
      ->add_option("--continuity", arguments->continuity,
                   "What to hold it to: g0 no gap, g1 one normal, g2 one curvature")
      ->check(CLI::IsMember(choice_words<ContinuityClass>()));
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "Largest angle between the normals of both sides (0.5deg)")
      ->check(parses("ANGLE", [](const std::string& text) {
        const double angle = parse_angle(text);
        if (!(angle > 0 && angle <= kPi))
          throw InvalidInput("the tolerance is an angle above 0, at most 180 degrees");
      }));
  command->add_option("--gap", arguments->gap, "Largest gap between both sides, % of the size of the surface")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--curvature", arguments->curvature,
                   "For g2: largest difference of the curvatures, % of the larger one")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--distance", arguments->distance,
                   "Largest distance of a curve from the surface, % of its size")
      ->check(CLI::PositiveNumber);
  command->add_option("--pictures", arguments->pictures,
                      "Folder for a picture of isophotes around the worst place of every curve that fails");
}

}  // namespace batten::cli
