#include "command.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/simplification/simplify.hpp"

namespace batten::cli {

namespace {

struct SimplifyArguments {
  std::string input, output, remove, error, method = "quadric", weight = "w3", fidelity = "adaptive";
  std::string keep_edges = "off", levels_folder;
  long faces = 0;
  int levels = 3;
  double p = 0.1, alpha = 1, beta = 1, sigma = 0.5;
};

double parse_removed_fraction(const std::string& text) {
  const double fraction = parse_fraction(text);
  if (!(fraction > 0 && fraction < 1))
    throw InvalidInput(concat("must be above 0 % and below 100 %: ", text));
  return fraction;
}

Length parse_error_length(const std::string& text) {
  const Length length = parse_length(text);
  if (!(length.value > 0)) throw InvalidInput(concat("must be more than 0: ", text));
  return length;
}

std::optional<double> parse_fidelity(const std::string& text) {
  if (text == "adaptive") return std::nullopt;
  double value = 0;
  if (!parse_number(text, value) || !(value >= 0 && value < 1e300))
    throw InvalidInput(concat("takes adaptive or a number of at least 0, got ", text));
  return value;
}

double parse_keep_edges(const std::string& text) {
  if (text == "off") return 0;
  const double angle = parse_angle(text);
  if (!(angle > 0 && angle < kPi))
    throw InvalidInput(concat("takes off or an angle between 0deg and 180deg, got ", text));
  return angle;
}

FlowWeight weight_of(const std::string& name) {
  return name == "w1"   ? FlowWeight::Uniform
         : name == "w2" ? FlowWeight::InverseLength
                        : FlowWeight::Curvature;
}

Json side_figures(const DirectedComparison& side, double diameter) {
  Json figures = Json::object();
  figures["dmax"] = std::max(side.samples.max, side.vertices.max) / diameter;
  figures["dmean"] = side.samples.mean / diameter;
  figures["drms"] = side.samples.rms / diameter;
  return figures;
}

/// Level 0 is the input. Every mesh holds, per vertex, the vertex of the next coarser level that stands for
/// it ("coarser_vertex"; −1 where no face used it).
void write_levels(const std::string& folder, TriangleMesh finer, const std::vector<SimplifyLevel>& levels,
                  Outcome& outcome) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) throw FileError(folder, 0, concat("the folder cannot be made: ", problem.message()));
  Json written = Json::array();
  const auto write = [&](std::size_t number, const TriangleMesh& mesh) {
    const std::string path = concat(folder, "/level_", number, ".ply");
    write_mesh(path, mesh);
    Json entry = Json::object();
    entry["file"] = path;
    entry["vertices"] = mesh.n_vertices();
    entry["faces"] = mesh.n_triangles();
    written.push_back(entry);
  };
  for (std::size_t level = 0; level <= levels.size(); ++level) {
    if (level < levels.size()) {
      const std::vector<int>& map = levels[level].vertex_of_finer;
      Eigen::VectorXd values(static_cast<Eigen::Index>(map.size()));
      for (std::size_t v = 0; v < map.size(); ++v) values[static_cast<Eigen::Index>(v)] = map[v];
      finer.vertex_values["coarser_vertex"] = values;
    }
    write(level, finer);
    if (level < levels.size()) finer = levels[level].mesh;
  }
  outcome.figures["levels"] = written;
}

Outcome run_simplify(const SimplifyArguments& arguments, Context& context) {
  Outcome outcome;
  const int criteria =
      (arguments.faces > 0 ? 1 : 0) + (arguments.remove.empty() ? 0 : 1) + (arguments.error.empty() ? 0 : 1);
  if (criteria != 1)
    throw CLI::ValidationError("simplify", "give exactly one of --faces, --remove and --error");
  mesh_format(arguments.output);  // an unknown extension fails before the work, not after it
  TriangleMesh mesh;
  {
    const ScopedStage stage(outcome.times, "read");
    mesh = read_mesh(arguments.input, &outcome.warnings);
  }
  const double diameter = bounding_box_diagonal(mesh.positions);
  SimplifyOptions options;
  options.faces = arguments.faces;
  if (!arguments.remove.empty()) options.remove = parse_removed_fraction(arguments.remove);
  if (!arguments.error.empty())
    options.max_error = parse_error_length(arguments.error).in_file_units(diameter);
  options.method = arguments.method == "plaplacian" ? SimplifyMethod::PLaplacian : SimplifyMethod::Quadric;
  options.levels = arguments.levels;
  options.keep_levels = !arguments.levels_folder.empty();
  options.keep_edges = parse_keep_edges(arguments.keep_edges);
  options.alpha = arguments.alpha;
  options.beta = arguments.beta;
  options.flow.p = arguments.p;
  options.flow.sigma = arguments.sigma;
  options.flow.weight = weight_of(arguments.weight);
  options.flow.fidelity = parse_fidelity(arguments.fidelity);

  const SimplifyResult result = simplify(mesh, options, context.progress);
  outcome.times.add(result.times);
  outcome.warnings.insert(outcome.warnings.end(), result.warnings.begin(), result.warnings.end());
  if (mesh.normals.rows() > 0 || !mesh.vertex_values.empty())
    outcome.warnings.emplace_back("normals and values per vertex of the input were dropped");
  {
    const ScopedStage stage(outcome.times, "write");
    write_mesh(arguments.output, result.mesh);
    if (options.keep_levels) {
      mesh.normals.resize(0, 3);
      mesh.vertex_values.clear();
      write_levels(arguments.levels_folder, mesh, result.levels, outcome);
    }
  }
  const ScopedStage stage(outcome.times, "check");
  const Comparison comparison =
      compare({mesh.positions, mesh.triangles, {}}, {result.mesh.positions, result.mesh.triangles, {}}, {},
              context.progress);
  const MeshQuality quality = mesh_quality(result.mesh.positions, result.mesh.triangles);
  const std::size_t before = self_intersections(mesh.positions, mesh.triangles).size();
  const std::size_t after = self_intersections(result.mesh.positions, result.mesh.triangles).size();
  outcome.figures["vertices"] = result.mesh.n_vertices();
  outcome.figures["faces"] = result.mesh.n_triangles();
  outcome.figures["input_vertices"] = mesh.n_vertices();
  outcome.figures["input_faces"] = mesh.n_triangles();
  outcome.figures["removed"] = 1 - double(result.mesh.n_triangles()) / double(mesh.n_triangles());
  outcome.figures["collapses"] = result.collapses;
  outcome.figures["diameter"] = diameter;
  outcome.figures["input_to_result"] = side_figures(comparison.a_to_b, diameter);
  outcome.figures["result_to_input"] = side_figures(comparison.b_to_a, diameter);
  outcome.figures["min_angle_deg"] = degrees(quality.min_angle);
  outcome.figures["mean_min_angle_deg"] = degrees(quality.mean_min_angle);
  outcome.figures["input_self_intersections"] = before;
  outcome.figures["self_intersections"] = after;
  outcome.lines.push_back(concat(arguments.output, ": ", result.mesh.n_vertices(), " vertices, ",
                                 result.mesh.n_triangles(), " faces (of ", mesh.n_triangles(), ")"));
  outcome.lines.push_back(
      concat("distance over the diameter: largest ",
             std::max(comparison.a_to_b.samples.max, comparison.b_to_a.samples.max) / diameter,
             ", root mean square ", comparison.a_to_b.samples.rms / diameter));
  outcome.lines.push_back(concat("mean smallest angle ", degrees(quality.mean_min_angle), " degrees, ", after,
                                 " self-intersections (input ", before, ")"));
  return outcome;
}

}  // namespace

void add_simplify(CLI::App& app) {
  auto arguments = std::make_shared<SimplifyArguments>();
  CLI::App* command =
      add_command(app, "simplify", "Reduce the number of triangles of a mesh.",
                  "batten simplify igea.ply -o small.ply --remove 95%",
                  [arguments](Context& context) { return run_simplify(*arguments, context); });
  command->add_option("IN", arguments->input, "Mesh (PLY, OBJ, OFF, STL)")->required();
  command->add_option("-o,--output", arguments->output, "Mesh to write; its extension decides the format")
      ->required();
  command->add_option("--faces", arguments->faces, "Keep at most this many faces")
      ->check(CLI::PositiveNumber);
  command->add_option("--remove", arguments->remove, "Remove this share of the faces (95%)")
      ->check(parses("FRACTION", parse_removed_fraction));
  command
      ->add_option("--error", arguments->error,
                   "Stay within this distance of the input, in both directions (2mm, 0.5%)")
      ->check(parses("LENGTH", parse_error_length));
  command->add_option("--levels", arguments->levels, "Levels of plaplacian and of --keep-all-levels")
      ->check(CLI::Range(1, 100));
  command->add_option("--method", arguments->method, "Which edges go: quadric or plaplacian (H 2.4)")
      ->check(CLI::IsMember({"quadric", "plaplacian"}));
  command
      ->add_option("--keep-edges", arguments->keep_edges,
                   "Edges sharper than this angle stay edges (30deg), or off: as the error asks for it")
      ->check(parses("ANGLE|off", parse_keep_edges));
  command->add_option("--p", arguments->p, "plaplacian: exponent of the flow, above 0 to 2")
      ->check(CLI::Range(1e-3, 2.0));
  command->add_option("--alpha", arguments->alpha, "plaplacian: exponent of the error in (2.100)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--beta", arguments->beta, "plaplacian: exponent of the length in (2.100)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--weight", arguments->weight, "plaplacian: w1 even, w2 by length, w3 by curvature")
      ->check(CLI::IsMember({"w1", "w2", "w3"}));
  command->add_option("--sigma", arguments->sigma, "plaplacian: width of w3; smaller keeps sharper features")
      ->check(CLI::PositiveNumber);
  command->add_option("--fidelity", arguments->fidelity, "plaplacian: adaptive, or one number for all")
      ->check(parses("adaptive|NUMBER", parse_fidelity));
  command->add_option("--keep-all-levels", arguments->levels_folder,
                      "Folder for the mesh of every level with its map to the next coarser one");
}

}  // namespace batten::cli
