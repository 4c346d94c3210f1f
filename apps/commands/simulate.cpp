#include "commands/simulate.hpp"

#include "commands/words.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

namespace {

/// A length as a fraction of the diameter.
double relative_length(const std::string& text, double diameter) {
  return parse_length(text).in_file_units(diameter) / diameter;
}

/// Those that do not depend on the object.
SimulateOptions free_options(const SimulateArguments& arguments) {
  SimulateOptions options;
  options.seed = arguments.seed;
  options.jitter = arguments.jitter;
  options.dwell = arguments.dwell;
  options.orientation_noise = parse_angle(arguments.orientation_noise);
  options.drift = parse_angle(arguments.drift);
  options.odometer_error = parse_fraction(arguments.odometer_error);
  options.outliers = parse_fraction(arguments.outliers);
  options.disturbance = parse_angle(arguments.disturbance);
  options.curve_length_error = parse_fraction(arguments.curve_length_error);
  options.speed_variation = parse_fraction(arguments.speed_variation);
  if (const auto problem = options.problem()) throw UsageError(*problem);
  return options;
}

GyroscopeOptions gyroscope_of(const SimulateArguments& arguments, double noise) {
  GyroscopeOptions options;
  options.rate = arguments.gyroscope_rate;
  options.warming = arguments.gyroscope_warming;
  const auto angle = [](const std::string& text, double& value) {
    if (!text.empty()) value = parse_angle(text);
  };
  angle(arguments.gyroscope_bias, options.bias);
  angle(arguments.gyroscope_walk, options.walk);
  angle(arguments.gyroscope_misalignment, options.misalignment);
  angle(arguments.gyroscope_temperature, options.temperature);
  if (!arguments.gyroscope_scale.empty()) options.scale = parse_fraction(arguments.gyroscope_scale);
  options.noise = noise;
  if (const auto problem = options.problem()) throw UsageError(*problem);
  return options;
}

}  // namespace

SimulatedObject traced_shape(const std::string& name) {
  SimulatedObject object;
  object.shape = choices_of(AnalyticShape{}).find(name);
  if (!object.shape) {
    std::string names;
    for (const std::string& word : choice_words<AnalyticShape>()) names += (names.empty() ? "" : ", ") + word;
    throw UsageError(concat("'", name, "' is neither a shape (", names, ") nor a mesh file"));
  }
  object.traced = trace_shape(*object.shape);
  return object;
}

SimulatedObject traced_mesh(TriangleMesh mesh, const SimulateArguments& arguments) {
  SimulatedObject object;
  MeshSectionOptions options;
  options.planes = arguments.planes;
  options.axes.clear();
  for (const std::string_view axis : split_fields(arguments.axes, ',')) options.axes += axis;
  if (const auto problem = options.problem()) throw UsageError(*problem);
  object.traced = trace_mesh(mesh, options);
  object.mesh = std::move(mesh);
  return object;
}

SimulateOptions options_of(const SimulateArguments& arguments, double diameter) {
  SimulateOptions options = free_options(arguments);
  options.step = relative_length(arguments.step, diameter);
  options.drift_length = relative_length(arguments.drift_length, diameter);
  if (const auto problem = options.problem()) throw UsageError(*problem);
  return options;
}

void check_arguments(const SimulateArguments& arguments, bool tumble) {
  if (arguments.gyroscope && !arguments.raw)
    throw UsageError("--gyroscope needs --raw: a scan of orientations has no gyroscope");
  if (arguments.nodes != "numbered" && arguments.raw)
    throw UsageError("--nodes is for scans of orientations: logs of --raw number their nodes");
  if (tumble && !arguments.raw)
    throw UsageError("--tumble needs --raw: a scan of orientations has no sensors to calibrate");
  if (arguments.nodes != "numbered" && arguments.nodes != "stays" && arguments.nodes != "none")
    throw UsageError(concat("--nodes must be numbered, stays or none, got '", arguments.nodes, "'"));
  free_options(arguments);
}

Simulation simulate(const SimulateArguments& arguments, const SimulatedObject& object, bool tumble) {
  Simulation result;
  result.simulated = simulate_scan(object.traced, options_of(arguments, object.traced.diameter));
  if (!arguments.raw) return result;
  DeviceModel device = make_device(arguments.seed, arguments.sensor_noise);
  if (!arguments.distortion) {
    DeviceModel ideal;
    ideal.accelerometer_noise = device.accelerometer_noise;
    ideal.magnetometer_noise = device.magnetometer_noise;
    ideal.gyroscope_noise = device.gyroscope_noise;
    ideal.knocks = device.knocks;
    device = ideal;
  }
  if (arguments.gyroscope)
    add_gyroscope(device, gyroscope_of(arguments, device.gyroscope_noise), arguments.seed);
  result.log = simulate_log(object.traced, result.simulated, device, arguments.seed);
  if (tumble) result.tumble = simulate_tumble(device, arguments.seed);
  return result;
}

CurveNetwork true_network(const SimulateArguments& arguments, const SimulatedObject& object) {
  return truth_network(object.traced,
                       parse_length(arguments.truth_step).in_file_units(object.traced.diameter));
}

TriangleMesh true_mesh(const SimulateArguments& arguments, const SimulatedObject& object) {
  return object.mesh
             ? *object.mesh
             : shape_mesh(*object.shape, relative_length(arguments.truth_edge, object.traced.diameter));
}

Json figures_of(const SimulatedObject& object, const SimulatedScan& simulated) {
  const Scan& scan = simulated.scan;
  Eigen::Index readings = 0;
  size_t segments = 0;
  int boundary_curves = 0;
  double length = 0;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const ScanCurve& curve = scan.curves[c];
    readings += curve.n_readings();
    segments += std::max<size_t>(curve.node_ids.size(), 2) - 1;
    boundary_curves += curve.boundary ? 1 : 0;
    length += object.traced.curves[c].path->length();
  }
  Json figures = Json::object();
  figures["curves"] = scan.curves.size();
  figures["nodes"] = object.traced.node_positions.rows();
  figures["segments"] = segments;
  figures["boundary_curves"] = boundary_curves;
  figures["readings"] = readings;
  figures["diameter"] = object.traced.diameter;
  figures["length"] = length;
  const SimulateReport& report = simulated.report;
  Json drawn = Json::object();
  drawn["orientation_noise_deg"] = degrees(report.rms_orientation_noise);
  drawn["drift_deg"] = degrees(report.rms_drift);
  drawn["distance_factors"] = report.distance_factors;
  drawn["outliers"] = report.n_outliers;
  drawn["disturbed_curve"] = report.disturbed_curve < 0 ? Json(nullptr) : Json(report.disturbed_curve + 1);
  if (report.disturbed_curve >= 0) drawn["disturbed_at"] = report.disturbed_centre;
  figures["drawn"] = drawn;
  return figures;
}

void leave_out_numbers(const std::string& nodes, Scan& scan) {
  for (ScanCurve& curve : scan.curves) {
    if (nodes == "stays") std::fill(curve.node_ids.begin(), curve.node_ids.end(), kNoNodeNumber);
    if (nodes != "none") continue;
    curve.node_readings.clear();
    curve.node_ids.clear();
  }
}

}  // namespace batten::commands
