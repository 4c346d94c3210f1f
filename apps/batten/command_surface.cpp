#include "command.hpp"
#include "sketch_stage.hpp"
#include "surface_stage.hpp"

#include <memory>

#include "batten/io/network_io.hpp"

namespace batten::cli {

void add_surface(CLI::App& app) {
  const auto arguments = std::make_shared<SurfaceArguments>();
  const auto sketch = std::make_shared<SketchArguments>();
  const auto input = std::make_shared<std::string>();
  CLI::App* command =
      add_command(app, "surface", "Fill a curve network, or a sketch without normals, with a fair surface.",
                  "batten surface net.net -o surface.ply", [arguments, sketch, input](Context& context) {
                    check_surface_output(*arguments);
                    Outcome outcome;
                    CurveNetwork network;
                    {
                      const ScopedStage stage(outcome.times, "read");
                      network = read_network(*input, &outcome.warnings);
                    }
                    std::vector<NetworkCycle> cycles;
                    if (!network.has_normals()) cycles = run_sketch_stage(*sketch, network, context, outcome);
                    run_surface_stage(*arguments, network, context, outcome, cycles);
                    return outcome;
                  });
  command->add_option("network", *input, "Network or sketch: .net, .obj, .json, .txt or .lop")->required();
  add_surface_options(*command, *arguments);
  add_sketch_options(*command, *sketch);
  command
      ->add_option("--crossings", arguments->crossings,
                   "Without normals: patches that would cross others or fold are filled flatter, or kept")
      ->check(CLI::IsMember({"flatten", "keep"}));
}

}  // namespace batten::cli
