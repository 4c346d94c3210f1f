#include "commands/network.hpp"

#include "commands/words.hpp"

#include <cmath>
#include <string_view>
#include <vector>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

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

}  // namespace

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

ScanOptions options_of(const NetworkArguments& arguments) {
  ScanOptions options;
  parse_step(arguments.step, options);
  parse_weights(arguments.weights, options);
  options.energy = parse_choice<RegressionEnergy>(arguments.energy);
  options.xi = arguments.xi;
  options.robust = is_first_word(arguments.robust, "--robust", "on", "off");
  options.scheme = parse_choice<IntegrationScheme>(arguments.scheme);
  options.lengths = parse_choice<LengthChoice>(arguments.lengths);
  options.uncertainty = arguments.uncertainty;
  if (const auto problem = options.problem()) throw UsageError(*problem);
  return options;
}

Json figures_of(const NodeInference& found) {
  Json nodes = Json::array();
  int n_sure = 0;
  for (const InferredNode& node : found.nodes) {
    nodes.push_back(node_json(node));
    n_sure += node.is_sure ? 1 : 0;
  }
  Json inferred = {{"stays", found.n_stays}, {"nodes", nodes}, {"sure", n_sure}, {"doubts", found.doubts}};
  inferred["margin"] = std::isfinite(found.margin) ? Json(found.margin) : Json(nullptr);
  return inferred;
}

Json figures_of(const ScanNetwork& result) {
  const ScanReport& report = result.report;
  Json f = Json::object();
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
  return f;
}

}  // namespace batten::commands
