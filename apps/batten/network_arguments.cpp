#include "network_arguments.hpp"

#include <string>
#include <utility>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
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
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  return options;
}

Scan read_network_scan(const NetworkArguments& arguments, Outcome& outcome) {
  const ScopedStage stage(outcome.times, "read");
  LogScanOptions options;
  if (!arguments.calibration.empty()) options.calibration = read_calibration(arguments.calibration);
  LogScan read = read_scan(arguments.input, options, arguments.columns);
  for (const std::string& warning : read.warnings) outcome.warnings.push_back(warning);
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
    write_network(arguments.output, result.network);
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
  f["undetermined"] = report.undetermined;
  f["closure_misfit_before"] = report.closure_misfit_before;
  f["closure_misfit"] = report.closure_misfit;

  outcome.lines.push_back(concat(writes ? arguments.output + ": " : std::string("network: "), report.n_curves,
                                 " curves, ", report.n_nodes, " nodes, ", report.n_segments, " segments, ",
                                 result.network.positions.rows(), " vertices"));
  outcome.lines.push_back(concat("size ", report.size, ", step ", report.step, "; ", report.n_readings,
                                 " readings, ", n_outliers, " outliers"));
  outcome.lines.push_back("weights: " + report.weights_reason);
  outcome.lines.push_back(concat("closure misfit ", report.closure_misfit_before, " unfiltered, ",
                                 report.closure_misfit, " now"));
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
                  "Integration: second order, or the first-order one of the thesis")
      ->check(CLI::IsMember(choice_words<IntegrationScheme>()));
  command
      .add_option("--lengths", arguments.lengths,
                  "measured, or estimated: right up to one factor per curve, which closure tells")
      ->check(CLI::IsMember(choice_words<LengthChoice>()));
}

}  // namespace batten::cli
