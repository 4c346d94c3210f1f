#include "command.hpp"
#include "commands/simplify.hpp"
#include "model_file.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/simplified_mesh.hpp"

namespace batten::cli {

namespace {

struct SimplifyArguments : commands::SimplifyArguments {
  std::string input, output, levels_folder;
};

/// Level 0 is the input.
void write_levels(const std::string& folder, const std::vector<TriangleMesh>& levels, Outcome& outcome) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) throw FileError(folder, 0, concat("the folder cannot be made: ", problem.message()));
  Json written = Json::array();
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const std::string path = concat(folder, "/level_", level, ".ply");
    write_mesh(path, levels[level]);
    Json entry = Json::object();
    entry["file"] = path;
    entry["vertices"] = levels[level].n_vertices();
    entry["faces"] = levels[level].n_triangles();
    written.push_back(entry);
  }
  outcome.figures["levels"] = written;
}

Outcome run_simplify(const SimplifyArguments& arguments, Context& context) {
  Outcome outcome;
  const SimplifiedMeshOptions options = options_of(arguments);
  mesh_format(arguments.output);  // an unknown extension fails before the work, not after it
  MeshFile input;
  {
    const ScopedStage stage(outcome.times, "read");
    input = read_mesh_to_process(arguments.input, outcome.warnings, arguments.repair, context.progress);
  }
  const TriangleMesh& mesh = input.mesh;
  const SimplifiedMesh result = simplified_mesh(mesh, options, context.progress);
  add_run(result.times, result.warnings, outcome);
  const TriangleMesh& small = result.simplified.mesh;
  {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.output, small, input, false, outcome);
    if (options.simplify.keep_levels)
      write_levels(arguments.levels_folder, level_meshes(mesh, result.simplified.levels), outcome);
  }
  const double diameter = result.diameter;
  const Comparison& distances = result.distances;
  commands::append(commands::figures_of(mesh, result), outcome.figures);
  outcome.lines.push_back(concat(arguments.output, ": ", small.n_vertices(), " vertices, ",
                                 small.n_triangles(), " faces (of ", mesh.n_triangles(), ")"));
  outcome.lines.push_back(
      concat("distance over the diameter: largest ",
             std::max(distances.a_to_b.samples.max, distances.b_to_a.samples.max) / diameter,
             ", root mean square ", distances.a_to_b.samples.rms / diameter));
  outcome.lines.push_back(concat("mean smallest angle ", degrees(result.quality.mean_min_angle), " degrees, ",
                                 result.crossings, " self-intersections (input ", result.input_crossings,
                                 ")"));
  return outcome;
}

}  // namespace

void add_simplify(CLI::App& app) {
  auto arguments = std::make_shared<SimplifyArguments>();
  CLI::App* command =
      add_command(app, "simplify", "Reduce the number of triangles of a mesh.",
                  "batten simplify igea.ply -o small.ply --remove 95%", [arguments](Context& context) {
                    arguments->keep_all_levels = !arguments->levels_folder.empty();
                    return run_simplify(*arguments, context);
                  });
  command->add_option("IN", arguments->input, "Mesh (PLY, OBJ, OFF, STL)")->required();
  command->add_option("-o,--output", arguments->output, "Mesh to write; its extension decides the format")
      ->required();
  command->add_option("--faces", arguments->faces, "Keep at most this many faces")
      ->check(CLI::PositiveNumber);
  command->add_option("--remove", arguments->remove, "Remove this share of the faces (95%)")
      ->check(parses("FRACTION", commands::parse_removed_fraction));
  command
      ->add_option("--error", arguments->error,
                   "Stay within this distance of the input, in both directions (2mm, 0.5%)")
      ->check(parses("LENGTH", commands::parse_error_length));
  command->add_option("--levels", arguments->levels, "Levels of plaplacian and of --keep-all-levels")
      ->check(CLI::Range(1, 100));
  command->add_option("--method", arguments->method, "Which edges go: quadric or plaplacian (H 2.4)")
      ->check(CLI::IsMember(choice_words<SimplifyMethod>()));
  command
      ->add_option("--keep-edges", arguments->keep_edges,
                   "Edges sharper than this angle stay edges (30deg), or off: as the error asks for it")
      ->check(parses("ANGLE|off", commands::parse_kept_angle));
  command
      ->add_option(
          "--keep-border", arguments->keep_border,
          "shape: as far as the error asks for it; exact: border vertices all stay, so that tiles join")
      ->check(CLI::IsMember({"shape", "exact"}));
  command->add_option("--p", arguments->p, "plaplacian: exponent of the flow, above 0 to 2")
      ->check(CLI::Range(1e-3, 2.0));
  command->add_option("--alpha", arguments->alpha, "plaplacian: exponent of the error in (2.100)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--beta", arguments->beta, "plaplacian: exponent of the length in (2.100)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--weight", arguments->weight, "plaplacian: w1 even, w2 by length, w3 by curvature")
      ->check(CLI::IsMember(choice_words<FlowWeight>()));
  command->add_option("--sigma", arguments->sigma, "plaplacian: width of w3; smaller keeps sharper features")
      ->check(CLI::PositiveNumber);
  command->add_option("--fidelity", arguments->fidelity, "plaplacian: adaptive, or one number for all")
      ->check(parses("adaptive|NUMBER", commands::parse_fidelity));
  command->add_option("--keep-all-levels", arguments->levels_folder,
                      "Folder for the mesh of every level with its map to the next coarser one");
  add_repair_flag(*command, arguments->repair);
}

}  // namespace batten::cli
