#include "network_arguments.hpp"

#include "uncertainty_figures.hpp"

#include <string>
#include <utility>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/scan/node_inference.hpp"
#include "batten/scan/reconstruct.hpp"

namespace batten::cli {

namespace {

/// The scan with the numbers found; they are written where that is asked for, in doubt as well.
std::optional<Scan> numbered_scan(const NetworkArguments& arguments, const Scan& scan,
                                  const Progress& progress, Outcome& outcome) {
  const ScopedStage stage(outcome.times, "nodes");
  NodeInference found = infer_nodes(scan, progress);
  outcome.figures["inferred_nodes"] = commands::figures_of(found);
  const int n_sure = outcome.figures["inferred_nodes"]["sure"].get<int>();
  outcome.lines.push_back(
      concat(found.nodes.size(), " nodes found from ", found.n_stays, " stays, ", n_sure, " of them sure"));
  if (!arguments.numbered.empty()) {
    write_rawnet(found.scan, arguments.numbered);
    outcome.lines.push_back("numbers: " + arguments.numbered);
  }
  if (found.is_sure()) return std::move(found.scan);
  for (const std::string& doubt : found.doubts) outcome.warnings.push_back(doubt);
  outcome.failure =
      concat("the numbers of the nodes are not sure, ", found.doubts.size(), " doubts; no network was made",
             arguments.numbered.empty()
                 ? std::string(": --numbered FILE.rawnet writes the proposal to be corrected and given back")
                 : concat(": correct ", arguments.numbered, " and give it back without --nodes auto"));
  return std::nullopt;
}

}  // namespace

std::optional<Scan> read_network_scan(const NetworkArguments& arguments, const Progress& progress,
                                      Outcome& outcome) {
  LogScan read;
  {
    const ScopedStage stage(outcome.times, "read");
    LogScanOptions options;
    if (!arguments.calibration.empty()) options.calibration = read_calibration(arguments.calibration);
    read = read_scan(arguments.input, options, arguments.columns,
                     arguments.nodes == "auto" ? NodeNumbers::MayMiss : NodeNumbers::Needed);
  }
  for (const std::string& warning : read.warnings) outcome.warnings.push_back(warning);
  if (arguments.nodes == "auto") return numbered_scan(arguments, read.scan, progress, outcome);
  if (!arguments.numbered.empty()) throw CLI::ValidationError("--numbered needs --nodes auto");
  return std::move(read.scan);
}

void check_network_output(const NetworkArguments& arguments) {
  if (!arguments.output.empty()) network_format(arguments.output);
}

void report_network(const NetworkArguments& arguments, const ScanNetwork& result, Outcome& outcome) {
  const ScanReport& report = result.report;
  outcome.times.add(report.times);
  for (const std::string& warning : report.warnings) outcome.warnings.push_back(warning);
  const bool writes = !arguments.output.empty();
  if (writes) {
    const ScopedStage stage(outcome.times, "write");
    if (result.uncertainty && network_format(arguments.output) == NetworkFormat::Json) {
      write_uncertain_network(arguments.output, result.network, result.uncertainty->deviations);
    } else {
      write_network(arguments.output, result.network);
      if (result.uncertainty)
        outcome.warnings.push_back(
            concat(arguments.output, ": cannot hold the uncertainty; write .json to keep it"));
    }
  }

  commands::append(commands::figures_of(result), outcome.figures);

  outcome.lines.push_back(concat(writes ? arguments.output + ": " : std::string("network: "), report.n_curves,
                                 " curves, ", report.n_nodes, " nodes, ", report.n_segments, " segments, ",
                                 result.network.positions.rows(), " vertices"));
  outcome.lines.push_back(concat("size ", report.size, ", step ", report.step, "; ", report.n_readings,
                                 " readings, ", outcome.figures["outliers"], " outliers"));
  outcome.lines.push_back("weights: " + report.weights_reason);
  if (!report.lengths.empty()) outcome.lines.push_back("lengths: " + report.lengths);
  outcome.lines.push_back(concat("closure misfit ", report.closure_misfit_before, " unfiltered, ",
                                 report.closure_misfit, " now"));
  if (result.uncertainty)
    report_uncertainty(result.network.positions, result.uncertainty->deviations, outcome);
  outcome.exhibit.network = result.network;
}

void add_network_options(CLI::App& command, NetworkArguments& arguments) {
  command.add_option("scan", arguments.input, "Scan to read: .rawnet, or a log of sensor readings (.csv)")
      ->required();
  command.add_option("--calibration", arguments.calibration,
                     "Calibration of the device that wrote a .csv log (batten calibrate)");
  add_columns_option(command, arguments.columns);
  command
      .add_option(
          "--step", arguments.step,
          "Distance between samples: a part of the size, a length, or none for the readings themselves")
      ->check(parses("STEP", [](const std::string& text) {
        ScanOptions ignored;
        commands::parse_step(text, ignored);
      }));
  command
      .add_option(
          "--weights", arguments.weights,
          "auto: from the data; thesis: 1,100 in the unit of the file; or LAMBDA,MU with lengths in sizes")
      ->check(parses("WEIGHTS", [](const std::string& text) {
        ScanOptions ignored;
        commands::parse_weights(text, ignored);
      }));
  command
      .add_option("--energy", arguments.energy,
                  "Form of the smoothing energy: free of resolution and unit, or as printed")
      ->check(CLI::IsMember(choice_words<RegressionEnergy>()));
  command.add_option("--xi", arguments.xi, "Weight of equal normals at nodes")->check(CLI::NonNegativeNumber);
  command.add_option("--robust", arguments.robust, "Distrust outliers and disturbed pieces")
      ->check(CLI::IsMember({"on", "off"}));
  command
      .add_option("--scheme", arguments.scheme,
                  "Integration: fourth order, or the first-order one of the thesis")
      ->check(CLI::IsMember(choice_words<IntegrationScheme>()));
  command.add_flag("--uncertainty", arguments.uncertainty,
                   "Tell how sure every vertex is: a value per vertex of .json and .ply, and figures");
  command
      .add_option("--nodes", arguments.nodes,
                  "given: as numbered in the scan; auto: found from the stays of the device, and shown with "
                  "their evidence")
      ->check(CLI::IsMember({"given", "auto"}));
  command.add_option("--numbered", arguments.numbered,
                     "With --nodes auto: write the scan with the numbers found, .rawnet, to be corrected");
  command
      .add_option("--lengths", arguments.lengths,
                  "measured, or estimated, from time stamps: right up to a factor that may change along each "
                  "curve, which closure tells")
      ->check(CLI::IsMember(choice_words<LengthChoice>()));
}

}  // namespace batten::cli
