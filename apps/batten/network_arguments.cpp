#include "network_arguments.hpp"

#include "uncertainty_figures.hpp"

#include <cmath>
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

void parse_step(const std::string& text, ScanOptions& options) {
  if (text == "none") {
    options.step.reset();
    return;
  }
  options.step = parse_length(text);
  if (!(options.step->value > 0)) throw InvalidInput(concat("the step must be above 0, got ", text));
}

void parse_weights(const std::string& text, ScanOptions& options) {
  if (text == "auto") {
    options.weights = WeightChoice::Auto;
    return;
  }
  if (text == "thesis") {
    options.weights = WeightChoice::Thesis;
    return;
  }
  const std::vector<std::string_view> fields = split_fields(text, ',');
  options.weights = WeightChoice::Given;
  if (fields.size() != 2 || !parse_number(fields[0], options.lambda) || !parse_number(fields[1], options.mu))
    throw InvalidInput("weights are auto, thesis or two numbers LAMBDA,MU, got " + text);
  if (!(options.lambda >= 0 && options.mu >= 0))
    throw InvalidInput("the weights LAMBDA,MU must be at least 0, got " + text);
}

}  // namespace

ScanOptions scan_options(const NetworkArguments& arguments) {
  ScanOptions options;
  parse_step(arguments.step, options);
  parse_weights(arguments.weights, options);
  options.energy = parse_choice<RegressionEnergy>(arguments.energy);
  options.xi = arguments.xi;
  options.robust = arguments.robust == "on";
  options.scheme = parse_choice<IntegrationScheme>(arguments.scheme);
  options.lengths = parse_choice<LengthChoice>(arguments.lengths);
  options.uncertainty = arguments.uncertainty;
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  return options;
}

namespace {

Json node_json(const InferredNode& node) {
  Json visits = Json::array();
  for (const NodeVisit& visit : node.visits)
    visits.push_back({{"curve", visit.curve + 1},
                      {"reading", visit.reading + 1},
                      {"distance", visit.distance},
                      {"normal_angle_deg", degrees(visit.normal_angle)},
                      {"misfit_percent", 100 * visit.misfit},
                      {"margin", visit.margin}});
  Json json = {{"number", node.number}, {"sure", node.is_sure}, {"visits", visits}};
  if (!node.is_sure) json["doubt"] = node.doubt;
  return json;
}

/// The scan with the numbers found; they are written where that is asked for, in doubt as well.
std::optional<Scan> numbered_scan(const NetworkArguments& arguments, const Scan& scan,
                                  const Progress& progress, Outcome& outcome) {
  const ScopedStage stage(outcome.times, "nodes");
  NodeInference found = infer_nodes(scan, progress);
  Json nodes = Json::array();
  int n_sure = 0;
  for (const InferredNode& node : found.nodes) {
    nodes.push_back(node_json(node));
    n_sure += node.is_sure ? 1 : 0;
  }
  Json inferred = {{"stays", found.n_stays}, {"nodes", nodes}, {"sure", n_sure}, {"doubts", found.doubts}};
  inferred["margin"] = std::isfinite(found.margin) ? Json(found.margin) : Json(nullptr);
  outcome.figures["inferred_nodes"] = inferred;
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

  Json& f = outcome.figures;
  int n_outliers = 0;
  for (const int n : report.outliers) n_outliers += n;
  f["curves"] = report.n_curves;
  f["nodes"] = report.n_nodes;
  f["segments"] = report.n_segments;
  f["components"] = 1;
  f["loops"] = report.n_loops;
  f["vertices"] = result.network.positions.rows();
  f["readings"] = report.n_readings;
  f["duplicates"] = report.n_duplicates;
  f["outliers"] = n_outliers;
  f["outliers_per_curve"] = report.outliers;
  f["distrusted_per_curve"] = report.distrusted;
  f["size"] = report.size;
  f["step"] = report.step;
  f["tangents"] = report.convention.convention == TangentConvention::ToNext ? "to-next" : "at-sample";
  f["tangents_reason"] = report.convention.reason;
  f["reading_noise_deg"] = degrees(report.reading_noise);
  f["lambda"] = report.lambda;
  f["mu"] = report.mu;
  f["weights_reason"] = report.weights_reason;
  if (report.noise) {
    const NoiseModel& n = *report.noise;
    f["noise"] = {{"white_deg", degrees(n.white)},
                  {"drift_deg", degrees(n.drift)},
                  {"drift_length", n.drift_length},
                  {"odometer", n.scale},
                  {"stretch", n.stretch},
                  {"bending", n.bending},
                  {"jerk", n.jerk}};
    f["evidence"] = report.evidence;
  } else {
    f["energy"] = {{"total", report.regression.energy},
                   {"E_N", report.regression.E_N},
                   {"E_0", report.regression.E_0},
                   {"E_1", report.regression.E_1},
                   {"E_2", report.regression.E_2}};
  }
  if (report.gyroscope) {
    const ScanGyroscope& g = *report.gyroscope;
    f["gyroscope"] = {{"bias_deg_s", {degrees(g.bias[0]), degrees(g.bias[1]), degrees(g.bias[2])}},
                      {"bias_range_deg_s", degrees(g.bias_range)},
                      {"matrix_error", g.matrix.norm()},
                      {"noise_deg_sqrt_s", degrees(g.density)}};
  }
  f["iterations"] = report.iterations;
  f["length_factors"] = report.factors;
  f["length_factor_deviations"] = report.factor_deviations;
  f["speed_variation"] = report.speed_spread;
  if (!report.lengths.empty()) f["lengths"] = report.lengths;
  f["undetermined"] = report.undetermined;
  f["closure_misfit_before"] = report.closure_misfit_before;
  f["closure_misfit"] = report.closure_misfit;

  outcome.lines.push_back(concat(writes ? arguments.output + ": " : std::string("network: "), report.n_curves,
                                 " curves, ", report.n_nodes, " nodes, ", report.n_segments, " segments, ",
                                 result.network.positions.rows(), " vertices"));
  outcome.lines.push_back(concat("size ", report.size, ", step ", report.step, "; ", report.n_readings,
                                 " readings, ", n_outliers, " outliers"));
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
        parse_step(text, ignored);
      }));
  command
      .add_option(
          "--weights", arguments.weights,
          "auto: from the data; thesis: 1,100 in the unit of the file; or LAMBDA,MU with lengths in sizes")
      ->check(parses("WEIGHTS", [](const std::string& text) {
        ScanOptions ignored;
        parse_weights(text, ignored);
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
