#include "command.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/cage_io.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/step.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten::cli {

namespace {

struct SubdivideArguments {
  std::string cage, output, scheme = "catmull-clark", corners = "sharp", step, step_tolerance = "0.001%",
                            unit = "m";
  int levels = 3;
  double knots = 0.5;
  bool limit = false;
};

/// The schemes of a list such as "nulissmod,catmull-clark". @throws InvalidInput.
std::vector<SubdivisionScheme> parse_schemes(const std::string& text) {
  std::vector<SubdivisionScheme> schemes;
  for (const std::string_view name : split_fields(text, ',')) {
    if (name == "catmull-clark")
      schemes.push_back(SubdivisionScheme::CatmullClark);
    else if (name == "nuliss")
      schemes.push_back(SubdivisionScheme::Nuliss);
    else if (name == "nulissmod")
      schemes.push_back(SubdivisionScheme::NulissMod);
    else if (name == "linear")
      schemes.push_back(SubdivisionScheme::Linear);
    else
      throw InvalidInput(concat("'", name, "' is no scheme; use catmull-clark, nuliss, nulissmod or linear"));
  }
  return schemes;
}

/// Millimetres in the unit of the cage. @throws InvalidInput.
double parse_unit(const std::string& text) {
  const Length one = parse_length("1" + text);
  if (one.kind != Length::Kind::Metres)
    throw InvalidInput(concat("'", text, "' is no unit of length; use m, cm, mm, um, km, in or ft"));
  return 1000 * one.value;
}

/// Quads cut along the diagonal from their first corner, other polygons by ears.
TriangleMesh as_triangles(const PolygonMesh& mesh) {
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f)
    if (mesh.offsets[f + 1] - mesh.offsets[f] != 4) return triangulated(mesh);
  TriangleMesh triangles;
  triangles.positions = mesh.positions;
  triangles.triangles = cut_at_first_corners(mesh);
  return triangles;
}

void check_arguments(const SubdivideArguments& arguments) {
  if (arguments.output.empty() && arguments.step.empty())
    throw CLI::ValidationError("subdivide", "needs an output: -o for a mesh, --step for CAD, or both");
  if (!arguments.output.empty()) mesh_format(arguments.output);
  if (!arguments.step.empty()) {
    const std::string extension = file_extension(arguments.step);
    if (extension != "step" && extension != "stp")
      throw FileError(arguments.step, 0, "is no STEP file by its extension; use .step or .stp");
    if (parse_schemes(arguments.scheme).back() != SubdivisionScheme::CatmullClark)
      throw CLI::ValidationError("--step",
                                 "writes the limit surface of Catmull-Clark; the other schemes have no "
                                 "B-splines as their limit. Let --scheme end in catmull-clark");
    require_step();
  }
}

void write_surface(const SubdivideArguments& arguments, SubdividedSurface& surface, Outcome& outcome) {
  const bool is_smooth = surface.cage.sharp_edges.empty() && surface.cage.sharp_vertices.empty();
  Points normals(0, 3);
  if (arguments.limit) {
    surface.cage.mesh.positions = surface.limit_positions;
    if (is_smooth) normals = surface.limit_normals;
  }
  outcome.figures["vertices"] = surface.cage.mesh.positions.rows();
  outcome.figures["faces"] = surface.cage.mesh.n_faces();
  outcome.exhibit.mesh = as_triangles(surface.cage.mesh);
  if (arguments.output.empty()) return;
  const ScopedStage stage(outcome.times, "write");
  if (mesh_format(arguments.output) == MeshFormat::Stl) {
    outcome.warnings.emplace_back("STL holds triangles only: every quad was split into two");
    write_mesh(arguments.output, *outcome.exhibit.mesh);
  } else {
    write_cage(arguments.output, surface.cage, normals);
  }
  outcome.lines.push_back(concat(arguments.output, ": ", surface.cage.mesh.positions.rows(), " vertices, ",
                                 surface.cage.mesh.n_faces(), " faces"));
}

void write_step(const SubdivideArguments& arguments, const ControlCage& cage, const Context& context,
                Outcome& outcome) {
  BsplineOptions options;
  options.tolerance = parse_fraction(arguments.step_tolerance);
  options.smooth_corners = arguments.corners == "smooth";
  BsplineSurface surface;
  {
    const ScopedStage stage(outcome.times, "patches");
    surface = limit_bsplines(cage, options, context.progress);
  }
  const double millimetres = parse_unit(arguments.unit),
               diameter = bounding_box_diagonal(cage.mesh.positions);
  {
    const ScopedStage stage(outcome.times, "step");
    StepOptions step;
    step.millimetres_per_unit = millimetres;
    write_file(arguments.step, format_step(surface, step));
  }
  const auto n_exact = std::count_if(surface.patches.begin(), surface.patches.end(),
                                     [](const BsplinePatch& patch) { return patch.is_exact; });
  const auto n_sharp = std::count_if(surface.edges.begin(), surface.edges.end(),
                                     [](const BsplineEdge& edge) { return edge.is_sharp; });
  Json figures = Json::object();
  figures["patches"] = surface.patches.size();
  figures["exact_patches"] = n_exact;
  figures["edges"] = surface.edges.size();
  figures["sharp_edges"] = n_sharp;
  figures["closed"] = surface.is_closed;
  figures["solids"] = surface.is_closed ? surface.n_components : 0;
  figures["levels"] = surface.levels;
  figures["isolation"] = surface.isolation;
  figures["deviation_mm"] = surface.deviation * millimetres;
  figures["relative_deviation"] = diameter > 0 ? surface.deviation / diameter : 0;
  figures["normal_jump_deg"] = degrees(surface.normal_jump);
  outcome.figures["step"] = figures;
  outcome.lines.push_back(concat(arguments.step, ": ", surface.patches.size(), " B-spline patches, ", n_exact,
                                 " of them exact, the others within ", surface.deviation * millimetres,
                                 " mm of the limit surface"));
  if (surface.deviation > options.tolerance * diameter)
    outcome.warnings.push_back(concat("near extraordinary vertices the patches are ",
                                      surface.deviation * millimetres,
                                      " mm off, more than --step-tolerance; subdivide the cage once first"));
  if (surface.levels > 0)
    outcome.warnings.push_back(
        concat("faces that are no quads and semi-sharp features were resolved: patches lie ", surface.levels,
               " levels below the faces of the cage"));
}

Outcome run_subdivide(const SubdivideArguments& arguments, const Context& context) {
  check_arguments(arguments);
  Outcome outcome;
  ControlCage cage;
  {
    const ScopedStage stage(outcome.times, "read");
    cage = read_cage(arguments.cage, &outcome.warnings);
  }
  const std::vector<SubdivisionScheme> schemes = parse_schemes(arguments.scheme);
  SubdivisionOptions options;
  options.smooth_corners = arguments.corners == "smooth";
  options.knot_exponent = arguments.knots;
  const MeshTopology topology = [&] {
    const ScopedStage stage(outcome.times, "check");
    subdivide(cage, {.scheme = SubdivisionScheme::Linear, .levels = 0});  // names what is wrong with the cage
    return mesh_topology(as_triangles(cage.mesh).triangles, cage.mesh.positions.rows());
  }();
  outcome.figures["cage_vertices"] = cage.mesh.positions.rows();
  outcome.figures["cage_faces"] = cage.mesh.n_faces();
  outcome.figures["sharp_edges"] = cage.sharp_edges.size();
  outcome.figures["sharp_vertices"] = cage.sharp_vertices.size();
  outcome.figures["polylines"] = cage.polylines.size();
  outcome.figures["components"] = topology.n_components;
  outcome.figures["boundary_loops"] = topology.n_boundary_loops;
  if (const auto genus = topology.genus()) outcome.figures["genus"] = *genus;

  int levels = arguments.levels;
  {
    // Each scheme of a list but the last makes one level.
    const ScopedStage stage(outcome.times, "subdivide");
    for (size_t k = 0; k + 1 < schemes.size() && levels > 0; ++k, --levels) {
      options.scheme = schemes[k];
      options.levels = 1;
      cage = subdivide(cage, options, context.progress).cage;
    }
  }
  if (!arguments.output.empty() || arguments.step.empty()) {
    options.scheme = schemes.back();
    options.levels = levels;
    options.limit = arguments.limit;
    SubdividedSurface surface;
    {
      const ScopedStage stage(outcome.times, "subdivide");
      surface = subdivide(cage, options, context.progress);
    }
    write_surface(arguments, surface, outcome);
  }
  if (!arguments.step.empty()) write_step(arguments, cage, context, outcome);
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
      ->check(parses("SCHEME", [](const std::string& text) { parse_schemes(text); }));
  command->add_option("--levels", arguments->levels, "Levels of refinement, 0 to 12")
      ->check(CLI::Range(0, 12));
  command->add_flag("--limit", arguments->limit, "Move the vertices onto the limit surface");
  command->add_option("--step", arguments->step, "Also write the limit surface for CAD: .step or .stp");
  command
      ->add_option("--step-tolerance", arguments->step_tolerance,
                   "Distance from the limit surface at extraordinary vertices, of the diameter")
      ->check(parses("PERCENT", [](const std::string& text) {
        if (!(parse_fraction(text) > 0)) throw InvalidInput("--step-tolerance must be above 0, got " + text);
      }));
  command->add_option("--unit", arguments->unit, "Unit of the cage, for STEP, which is in millimetres")
      ->check(parses("UNIT", [](const std::string& text) { parse_unit(text); }));
  command->add_option("--corners", arguments->corners, "Corners of the border: sharp or smooth")
      ->check(CLI::IsMember({"sharp", "smooth"}));
  command
      ->add_option("--knots", arguments->knots,
                   "NULISS: exponent of the lengths, 0 uniform to 1 chord length")
      ->check(CLI::Range(0.0, 1.0));
}

}  // namespace batten::cli
