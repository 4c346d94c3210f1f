#include "command.hpp"
#include "commands/subdivide.hpp"
#include "step_output.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/cage_io.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/subdivided_cage.hpp"

namespace batten::cli {

namespace {

struct SubdivideArguments : commands::SubdivideArguments {
  std::string cage, output, step, step_tolerance = "0.001%", unit = "m";
};

void check_arguments(const SubdivideArguments& arguments) {
  if (arguments.output.empty() && arguments.step.empty())
    throw CLI::ValidationError("subdivide", "needs an output: -o for a mesh, --step for CAD, or both");
  if (!arguments.output.empty()) mesh_format(arguments.output);
  if (!arguments.step.empty()) {
    cad_format_of(arguments.step);
    if (commands::parse_schemes(arguments.scheme).back() != SubdivisionScheme::CatmullClark)
      throw CLI::ValidationError("--step",
                                 "writes the limit surface of Catmull-Clark; the other schemes have no "
                                 "B-splines as their limit. Let --scheme end in catmull-clark");
    require_step();
  }
}

/// With what is to be written.
SubdividedCageOptions all_options(const SubdivideArguments& arguments) {
  SubdividedCageOptions options = options_of(arguments);
  options.refine = !arguments.output.empty();
  if (!arguments.step.empty()) {
    options.patches.emplace();
    options.patches->tolerance = parse_fraction(arguments.step_tolerance);
    options.patches->format = cad_format_of(arguments.step);
    options.patches->step.millimetres_per_unit = 1000 * metres_per_unit(arguments.unit);
  }
  return options;
}

void write_refined(const SubdivideArguments& arguments, RefinedCage refined, Outcome& outcome) {
  const PolygonMesh& mesh = refined.cage.mesh;
  {
    const ScopedStage stage(outcome.times, "write");
    if (!holds_polygons(mesh_format(arguments.output)))
      write_mesh(arguments.output, refined.triangles);
    else
      write_cage(arguments.output, refined.cage, refined.normals);
  }
  outcome.lines.push_back(
      concat(arguments.output, ": ", mesh.positions.rows(), " vertices, ", mesh.n_faces(), " faces"));
  outcome.exhibit.mesh = std::move(refined.triangles);
}

void write_patches(const SubdivideArguments& arguments, const CagePatches& patches, Outcome& outcome) {
  {
    const ScopedStage stage(outcome.times, "step");
    write_file(arguments.step, patches.text);
  }
  const BsplineSurface& surface = patches.surface;
  Json figures = Json::object();
  figures["patches"] = surface.patches.size();
  figures["exact_patches"] = patches.n_exact;
  figures["edges"] = surface.edges.size();
  figures["sharp_edges"] = patches.n_sharp;
  figures["closed"] = surface.is_closed;
  figures["solids"] = surface.is_closed ? surface.n_components : 0;
  figures["levels"] = surface.levels;
  figures["isolation"] = surface.isolation;
  figures["deviation_mm"] = patches.deviation;
  figures["relative_deviation"] = patches.diameter > 0 ? surface.deviation / patches.diameter : 0;
  figures["normal_jump_deg"] = degrees(surface.normal_jump);
  outcome.figures["step"] = figures;
  outcome.lines.push_back(concat(arguments.step, ": ", surface.patches.size(), " B-spline patches, ",
                                 patches.n_exact, " of them exact, the others within ", patches.deviation,
                                 " mm of the limit surface"));
}

Outcome run_subdivide(const SubdivideArguments& arguments, const Context& context) {
  check_arguments(arguments);
  Outcome outcome;
  ControlCage cage;
  {
    const ScopedStage stage(outcome.times, "read");
    cage = read_cage(arguments.cage, &outcome.warnings);
  }
  if (!arguments.output.empty() && !holds_polygons(mesh_format(arguments.output)))
    outcome.warnings.emplace_back("this format holds triangles only: every quad was split into two");
  SubdividedCage result = subdivided_cage(cage, all_options(arguments), context.progress);
  add_run(result.times, result.warnings, outcome);
  outcome.figures = commands::figures_of(result);
  if (result.refined) write_refined(arguments, std::move(*result.refined), outcome);
  if (result.patches) write_patches(arguments, *result.patches, outcome);
  return outcome;
}

}  // namespace

void add_subdivide(CLI::App& app) {
  const auto arguments = std::make_shared<SubdivideArguments>();
  CLI::App* command = add_command(
      app, "subdivide", "Refine a cage of polygons into a smooth surface, also as B-splines for CAD.",
      "batten subdivide cage.obj -o smooth.ply --levels 3 --limit --step smooth.step",
      [arguments](Context& context) { return run_subdivide(*arguments, context); });
  command->add_option("cage", arguments->cage, "Polygons with what is sharp: .obj, .ply, .off or .stl")
      ->required();
  command->add_option("-o,--output", arguments->output, "Refined mesh: .ply, .obj, .off (quads) or .stl");
  command
      ->add_option("--scheme", arguments->scheme,
                   "catmull-clark, nuliss, nulissmod or linear; a list: each but the last makes one level")
      ->check(parses("SCHEME", [](const std::string& text) { commands::parse_schemes(text); }));
  command->add_option("--levels", arguments->levels, "Levels of refinement, 0 to 12")
      ->check(CLI::Range(0, 12));
  command->add_flag("--limit", arguments->limit, "Move the vertices onto the limit surface");
  command->add_option("--step", arguments->step,
                      "Also write the limit surface for CAD: .step, .stp, .iges or .igs");
  command
      ->add_option("--step-tolerance", arguments->step_tolerance,
                   "Distance from the limit surface at extraordinary vertices, of the diameter")
      ->check(parses("PERCENT", [](const std::string& text) {
        if (!(parse_fraction(text) > 0)) throw InvalidInput("--step-tolerance must be above 0, got " + text);
      }));
  command->add_option("--unit", arguments->unit, "Unit of the cage, for STEP, which is in millimetres")
      ->check(parses("UNIT", [](const std::string& text) { metres_per_unit(text); }));
  command->add_option("--corners", arguments->corners, "Corners of the border: sharp or smooth")
      ->check(CLI::IsMember({"sharp", "smooth"}));
  command
      ->add_option("--knots", arguments->knots,
                   "NULISS: exponent of the lengths, 0 uniform to 1 chord length")
      ->check(CLI::Range(0.0, 1.0));
}

}  // namespace batten::cli
