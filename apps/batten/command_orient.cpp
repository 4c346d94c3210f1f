#include "command.hpp"

#include <cmath>
#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/orientation_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/pipeline/device_orientation.hpp"

namespace batten::cli {

namespace {

struct OrientArguments {
  std::string input, output, columns, calibration;
  bool causal = false;
  bool magnetometer = true;
};

Json degrees_json(const Eigen::Vector3d& v) {
  return {degrees(v.x()), degrees(v.y()), degrees(v.z())};
}

/// Root mean square of a column, in degrees, over the rows that have a value.
double rms_deg(const Eigen::VectorXd& column) {
  double sum = 0;
  Eigen::Index n = 0;
  for (const double value : column) {
    if (!(value == value)) continue;
    sum += value * value;
    ++n;
  }
  return n > 0 ? degrees(std::sqrt(sum / static_cast<double>(n))) : 0;
}

Json magnetometer_json(const OrientationEstimate& e) {
  Json json = Json::object();
  json["used"] = e.magnetometer_used;
  if (!e.magnetometer_used) return json;
  json["field_strength_uT"] = e.field_strength;
  json["inclination_deg"] = degrees(e.inclination);
  json["heading_deviation_deg"] = degrees(e.magnetometer_deviation);
  json["rejected"] = e.magnetometer_rejected;
  json["offset_uT"] = {e.magnetometer_offset.x(), e.magnetometer_offset.y(), e.magnetometer_offset.z()};
  return json;
}

void tell(const OrientationEstimate& e, const SensorLog& log, const OrientArguments& arguments,
          Outcome& outcome) {
  const double duration = log.time[log.n_readings() - 1] - log.time[0];
  const Eigen::Vector3d& b = e.gyroscope_bias;
  const Eigen::Vector3d& f = e.accelerometer_bias;
  Json& figures = outcome.figures;
  figures["readings"] = log.n_readings();
  figures["duration_s"] = duration;
  figures["moving"] = e.moving;
  figures["longest_gap_s"] = e.longest_gap;
  figures["tilt_sd_deg"] = rms_deg(e.tilt_deviation);
  figures["heading_sd_deg"] = rms_deg(e.heading_deviation);
  figures["gyroscope"] = {{"bias_deg_s", degrees_json(b)},
                          {"bias_sd_deg_s", degrees_json(e.gyroscope_bias_deviation)}};
  figures["accelerometer"] = {{"bias_m_s2", {f.x(), f.y(), f.z()}}};
  figures["magnetometer"] = magnetometer_json(e);
  if (!arguments.causal) {
    Json matrix = Json::array();
    for (int i = 0; i < 3; ++i)
      matrix.push_back({e.gyroscope_matrix(i, 0), e.gyroscope_matrix(i, 1), e.gyroscope_matrix(i, 2)});
    figures["gyroscope"]["matrix_error"] = matrix;
    figures["residuals"] = {{"turn", e.rms_turn}, {"velocity", e.rms_velocity}, {"heading", e.rms_heading}};
    figures["rms_speed_m_s"] = e.rms_speed;
    figures["iterations"] = e.iterations;
    figures["converged"] = e.converged;
  }
  figures["output"] = arguments.output;
  outcome.lines.push_back(concat(log.n_readings(), " readings over ", duration, " seconds, ",
                                 std::lround(100 * e.moving), " % of them in motion"));
  outcome.lines.push_back(concat("tilt known to ", rms_deg(e.tilt_deviation), ", heading to ",
                                 rms_deg(e.heading_deviation), " degrees (standard deviations)"));
  outcome.lines.push_back(concat("gyroscope bias: ", degrees(b.x()), " ", degrees(b.y()), " ", degrees(b.z()),
                                 " degrees per second"));
  if (e.magnetometer_used)
    outcome.lines.push_back(concat("magnetometer: ", std::lround(100 * e.magnetometer_rejected),
                                   " % of its readings set aside; the field dips ", degrees(e.inclination),
                                   " degrees below the horizon"));
  outcome.lines.push_back(concat("orientations: ", arguments.output));
}

Outcome run_orient(const OrientArguments& arguments, const Context& context) {
  Outcome outcome;
  SensorLog log;
  DeviceOrientationOptions options;
  {
    const ScopedStage stage(outcome.times, "read");
    log = read_sensor_log(arguments.input, arguments.columns,
                          arguments.columns.empty() ? nullptr : &outcome.warnings);
    if (!arguments.calibration.empty())
      options.estimate.calibration = read_calibration(arguments.calibration);
  }
  options.causal = arguments.causal;
  options.estimate.magnetometer = arguments.magnetometer;
  DeviceOrientation result;
  try {
    result = device_orientation(log, options, context.progress);
  } catch (const InvalidInput& error) {
    throw FileError(arguments.input, 0, error.what());
  }
  {
    const ScopedStage stage(outcome.times, "write");
    write_orientations(result.estimate, log.time, arguments.output);
  }
  add_run(result.times, result.estimate.warnings, outcome);
  tell(result.estimate, log, arguments, outcome);
  return outcome;
}

}  // namespace

void add_orient(CLI::App& app) {
  auto arguments = std::make_shared<OrientArguments>();
  CLI::App* command =
      add_command(app, "orient", "Estimate how a device was held from a log of its inertial sensors",
                  "batten orient log.csv -o orientation.csv --columns auto",
                  [arguments](Context& context) { return run_orient(*arguments, context); });
  command->add_option("log", arguments->input, "Sensor log with gyroscope and accelerometer (.csv)")
      ->required();
  add_columns_option(*command, arguments->columns);
  command->add_option("-o,--output", arguments->output, "The orientation of every row (.csv)")->required();
  command->add_option("--calibration", arguments->calibration,
                      "Calibration of the device that wrote the log (batten calibrate)");
  command->add_flag("--causal", arguments->causal,
                    "Take each orientation from the readings up to it alone, as a live view does");
  command->add_flag("--magnetometer,!--no-magnetometer", arguments->magnetometer,
                    "Take north from the magnetometer; without it the heading starts at 0 and drifts");
}

}  // namespace batten::cli
