#include "command.hpp"
#include "surface_stage.hpp"

#include <memory>

#include "batten/io/network_io.hpp"

namespace batten::cli {

void add_surface(CLI::App& app) {
  const auto arguments = std::make_shared<SurfaceArguments>();
  const auto input = std::make_shared<std::string>();
  CLI::App* command =
      add_command(app, "surface", "Fill a curve network with a fair surface.",
                  "batten surface net.net -o surface.ply", [arguments, input](Context& context) {
                    check_surface_output(*arguments);
                    Outcome outcome;
                    CurveNetwork network;
                    {
                      const ScopedStage stage(outcome.times, "read");
                      network = read_network(*input, &outcome.warnings);
                    }
                    run_surface_stage(*arguments, network, context, outcome);
                    return outcome;
                  });
  command->add_option("network", *input, "Network with normals: .net, .obj or .json")->required();
  add_surface_options(*command, *arguments);
}

}  // namespace batten::cli
