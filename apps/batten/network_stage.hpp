#pragma once
#include "command.hpp"

#include <string>

#include "batten/scan/reconstruct.hpp"

namespace batten::cli {

/// The way from a scan to a network, as `network` and `reconstruct` share it.
struct NetworkArguments {
  std::string input, output, calibration;
  std::string step = "1.6%", weights = "auto", energy = "scaled", robust = "on", scheme = "midpoint",
              lengths = "measured";
  double xi = 10000;
};

/// Adds the scan and every option but the outputs.
void add_network_options(CLI::App& command, NetworkArguments& arguments);

/// Reads the scan, makes the network of it and writes it where `output` is not empty. Figures, lines,
/// warnings, times and the exhibit go to `outcome`.
ScanNetwork run_network_stage(const NetworkArguments& arguments, const Context& context, Outcome& outcome);

}  // namespace batten::cli
