#pragma once
#include "command.hpp"
#include "commands/network.hpp"

#include <optional>
#include <string>

#include "batten/scan/reconstruct.hpp"
#include "batten/scan/scan.hpp"

namespace batten::cli {

/// The way from a scan to a network, as `network` and `reconstruct` share it.
struct NetworkArguments : commands::NetworkArguments {
  std::string input, output, calibration, columns, numbered;
};

/// Adds the scan and every option but the outputs.
void add_network_options(CLI::App& command, NetworkArguments& arguments);

/// Reads the scan, with its calibration where one is given, and finds the numbers of its nodes where that is
/// wanted; they and what is doubtful about them go to `outcome`, with warnings and time.
/// @return nothing where numbers are in doubt: `outcome` has the failure.
std::optional<Scan> read_network_scan(const NetworkArguments& arguments, const Progress& progress,
                                      Outcome& outcome);

/// Writes the network where `output` is not empty, and adds figures, lines, warnings, times and the exhibit.
void report_network(const NetworkArguments& arguments, const ScanNetwork& network, Outcome& outcome);

/// Fails where the output cannot be written as a network, before any work is done.
void check_network_output(const NetworkArguments& arguments);

}  // namespace batten::cli
