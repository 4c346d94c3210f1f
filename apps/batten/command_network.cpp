#include "command.hpp"
#include "network_stage.hpp"

#include <memory>

namespace batten::cli {

void add_network(CLI::App& app) {
  const auto arguments = std::make_shared<NetworkArguments>();
  CLI::App* command = add_command(
      app, "network",
      "Turn a scan of orientations and distances into a curve network with positions and normals.",
      "batten network scan.rawnet -o network.json", [arguments](Context& context) {
        Outcome outcome;
        run_network_stage(*arguments, context, outcome);
        return outcome;
      });
  command->add_option("-o,--output", arguments->output, "Network to write: .net, .obj or .json")->required();
  add_network_options(*command, *arguments);
}

}  // namespace batten::cli
