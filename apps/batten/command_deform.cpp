#include "command.hpp"
#include "commands/deform.hpp"
#include "model_file.hpp"

#include <memory>
#include <string>

#include "batten/core/text.hpp"
#include "batten/io/handles_io.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/deformed_mesh.hpp"

namespace batten::cli {

namespace {

struct DeformArguments : commands::DeformArguments {
  std::string in, out, handles;
};

Outcome run_deform(const DeformArguments& arguments, Context& context) {
  Outcome outcome;
  mesh_format(arguments.out);
  MeshFile input;
  Handles handles;
  {
    const ScopedStage stage(outcome.times, "read");
    input = read_mesh_to_process(arguments.in, outcome.warnings, arguments.repair, context.progress);
    handles = read_handles(arguments.handles, input.mesh.positions);
  }
  const TriangleMesh& mesh = input.mesh;
  const DeformedMesh result = deformed_mesh(mesh, handles, options_of(arguments), context.progress);
  add_run(result.times, result.warnings, outcome);
  {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.out, result.mesh, input, true, outcome);
  }
  outcome.figures = commands::figures_of(result);
  outcome.lines.push_back(concat(arguments.out, ": ", mesh.n_vertices(), " vertices, ", result.n_fixed,
                                 " fixed, ", result.n_moved, " moved, ", result.report.iterations,
                                 " iterations"));
  return outcome;
}

}  // namespace

void add_deform(CLI::App& app) {
  auto arguments = std::make_shared<DeformArguments>();
  CLI::App* command =
      add_command(app, "deform", "Bend, twist and stretch a surface by handles, its detail kept.",
                  "batten deform part.ply -o bent.ply --handles handles.json",
                  [arguments](Context& context) { return run_deform(*arguments, context); });
  command->add_option("IN", arguments->in, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->out, "Mesh to write; the extension decides the format")
      ->required();
  command->add_option("--handles", arguments->handles, "What is fixed and what moves (JSON, docs/deform.md)")
      ->required();
  command->add_option("--energy", arguments->energy, "stretch, bend, combined or total (curvature)")
      ->check(CLI::IsMember(choice_words<DeformationEnergy>()));
  command->add_option("--nonlinear", arguments->nonlinear, "How detail turns with the surface")
      ->check(CLI::IsMember(choice_words<DetailPreservation>()));
  command->add_option("--soft", arguments->soft, "Weight of soft handles; 0 meets them exactly")
      ->check(CLI::Range(0.0, 1e12));
  command->add_flag("--multiresolution", arguments->multiresolution,
                    "Iterate on a simplified mesh, put the detail back, finish on the mesh itself");
  command->add_option("--iterations", arguments->iterations, "Most iterations per part of the motion")
      ->check(CLI::Range(1, 100000));
  add_repair_flag(*command, arguments->repair);
}

}  // namespace batten::cli
