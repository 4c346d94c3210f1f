#include "command.hpp"
#include "commands/fair.hpp"
#include "model_file.hpp"

#include <memory>
#include <string>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/faired_mesh.hpp"

namespace batten::cli {

namespace {

struct FairArguments : commands::FairArguments {
  std::string input, output;
};

Outcome run_fair(const FairArguments& arguments, Context& context) {
  Outcome outcome;
  MeshFile input;
  {
    const ScopedStage stage(outcome.times, "read");
    mesh_format(arguments.output);  // an extension that cannot be written is refused before the work
    input = read_mesh_to_process(arguments.input, outcome.warnings, arguments.repair, context.progress);
  }
  const TriangleMesh& mesh = input.mesh;
  const FairedMesh faired = faired_mesh(mesh, options_of(arguments), context.progress);
  add_run(faired.times, faired.warnings, outcome);
  {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.output, faired.mesh, input, true, outcome);
  }
  const std::string strategy = strategy_of(arguments, faired);
  outcome.figures = commands::figures_of(arguments, faired);

  outcome.lines.push_back(concat("faired ", mesh.n_vertices(), " vertices, ", mesh.n_triangles(),
                                 " triangles: method ", arguments.method, ", strategy ", strategy));
  outcome.lines.push_back(concat("noise ", faired.noise, " mean edge lengths; largest move ",
                                 faired.largest_move, "; normals turned by ",
                                 degrees(faired.mean_normal_change), " degrees in the mean"));
  if (faired.volume_change)
    outcome.lines.push_back(concat("volume changed by ", 100 * *faired.volume_change, " %"));
  outcome.lines.push_back(concat("wrote ", arguments.output));
  return outcome;
}

}  // namespace

void add_fair(CLI::App& app) {
  auto arguments = std::make_shared<FairArguments>();
  CLI::App* command = add_command(app, "fair", "Remove noise from a mesh and keep its edges.",
                                  "batten fair scan.ply -o smooth.ply",
                                  [arguments](Context& context) { return run_fair(*arguments, context); });
  command->add_option("IN", arguments->input, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->output, "Where to write; the extension gives the format")
      ->required();
  command
      ->add_option("--method", arguments->method,
                   "How: auto chooses by itself; the others are the thesis's flows and well-known filters")
      ->check(CLI::IsMember(choice_words<FairingMethod>()));
  command
      ->add_option("--noise", arguments->noise,
                   "Standard deviation of the noise in mean edge lengths, or auto to estimate it")
      ->check(parses("auto or a number", [](const std::string& text) { commands::parse_noise(text); }));
  command
      ->add_option("--iterations", arguments->iterations, "Rounds or steps; 0 takes the method's own number")
      ->check(CLI::Range(0, 100000));
  command->add_flag("--keep-boundary", arguments->keep_boundary, "Keep border vertices in place");
  add_repair_flag(*command, arguments->repair);
}

}  // namespace batten::cli
