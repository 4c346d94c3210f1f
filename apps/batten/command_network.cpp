#include "command.hpp"
#include "network_arguments.hpp"

#include <memory>
#include <optional>

namespace batten::cli {

void add_network(CLI::App& app) {
  const auto arguments = std::make_shared<NetworkArguments>();
  CLI::App* command = add_command(
      app, "network",
      "Turn a scan of orientations and distances into a curve network with positions and normals.",
      "batten network scan.rawnet -o network.json", [arguments](Context& context) {
        Outcome outcome;
        const ScanOptions options = options_of(*arguments);
        check_network_output(*arguments);
        const std::optional<Scan> scan = read_network_scan(*arguments, context.progress, outcome);
        if (scan) report_network(*arguments, network_from_scan(*scan, options, context.progress), outcome);
        return outcome;
      });
  command->add_option("-o,--output", arguments->output, "Network to write: .net, .obj or .json")->required();
  add_network_options(*command, *arguments);
}

}  // namespace batten::cli
