#include "command.hpp"
#include "commands/repair.hpp"
#include "model_file.hpp"

#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/repaired_mesh.hpp"

namespace batten::cli {

namespace {

struct RepairArguments : commands::RepairArguments {
  std::string input, output;
};

Outcome run_repair(const RepairArguments& arguments, Context& context) {
  Outcome outcome;
  mesh_format(arguments.output);
  const RepairedMeshOptions options = options_of(arguments);
  MeshFile input;
  {
    const ScopedStage stage(outcome.times, "read");
    input = read_mesh_file(arguments.input, &outcome.warnings);
  }
  const TriangleMesh& mesh = input.mesh;
  RepairedMesh repaired;
  try {
    repaired = repaired_mesh(mesh, options, context.progress);
  } catch (const InvalidInput& problem) {
    throw InvalidInput(concat(arguments.input, ": ", problem.what()));
  }
  add_run(repaired.times, repaired.warnings, outcome);
  const bool is_written = repaired.flaws.empty() || arguments.accept_flaws;
  if (is_written) {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.output, repaired.mesh, input, false, outcome);
  }
  outcome.figures = commands::figures_of(mesh, repaired);
  outcome.figures["written"] = is_written;

  for (const std::string& line : repaired.done) outcome.lines.push_back(line);
  if (repaired.done.empty()) outcome.lines.emplace_back("nothing to repair");
  const std::size_t n_holes = outcome.figures["holes"].size();
  if (n_holes > 0 && options.fill_holes == 0)
    outcome.lines.push_back(concat(n_holes, n_holes == 1 ? " border is" : " borders are",
                                   " left; --fill-holes N fills those of up to N edges"));
  if (is_written)
    outcome.lines.push_back(concat("wrote ", arguments.output, ": ", repaired.mesh.n_vertices(),
                                   " vertices, ", repaired.mesh.n_triangles(), " triangles",
                                   repaired.topology.is_watertight() ? ", closed" : ""));
  report_flaws(repaired.flaws, concat("not all of ", arguments.input, " could be repaired"), arguments.output,
               arguments.accept_flaws, outcome);
  return outcome;
}

}  // namespace

void add_repair(CLI::App& app) {
  auto arguments = std::make_shared<RepairArguments>();
  CLI::App* command = add_command(app, "repair", "Mend a mesh: weld, orient, separate sheets, fill holes.",
                                  "batten repair broken.stl -o sound.ply --fill-holes 50",
                                  [arguments](Context& context) { return run_repair(*arguments, context); });
  command->add_option("IN", arguments->input, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->output, "Mesh to write; the extension decides the format")
      ->required();
  command
      ->add_option("--weld", arguments->weld,
                   "Weld borders that lie within this distance: auto, 0.01mm, 0.001% of the diameter, or off")
      ->check(parses("auto|LENGTH|off", [](const std::string& text) {
        commands::RepairArguments given;
        given.weld = text;
        options_of(given);
      }));
  command->add_flag("--orient", arguments->orient,
                    "Turn closed parts outward, and inward those that lie within another");
  command
      ->add_option("--fill-holes", arguments->fill_holes,
                   "Fill holes of up to N edges by fair surfaces, or all of them; 0 fills none")
      ->check(parses("N|all", [](const std::string& text) {
        commands::RepairArguments given;
        given.fill_holes = text;
        options_of(given);
      }));
  command->add_flag("--accept-flaws", arguments->accept_flaws,
                    "Write the result although not all could be repaired");
}

}  // namespace batten::cli
