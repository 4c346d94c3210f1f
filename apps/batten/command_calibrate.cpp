#include "command.hpp"

#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/scan/calibration.hpp"

namespace batten::cli {

namespace {

struct CalibrateArguments {
  std::string input, output, columns;
};

Json sensor_json(const SensorCalibration& sensor, const EllipsoidFitReport& report) {
  Json json = Json::object();
  json["offset"] = {sensor.offset.x(), sensor.offset.y(), sensor.offset.z()};
  json["matrix"] = Json::array();
  for (int i = 0; i < 3; ++i)
    json["matrix"].push_back({sensor.matrix(i, 0), sensor.matrix(i, 1), sensor.matrix(i, 2)});
  json["radius"] = report.radius;
  json["rms_before"] = report.rms_before;
  json["rms_residual"] = report.rms_residual;
  json["coverage"] = report.coverage;
  json["uncertainty"] = report.uncertainty;
  json["readings"] = report.readings;
  json["outliers"] = report.outliers;
  json["iterations"] = report.iterations;
  return json;
}

std::string sensor_line(const char* sensor, const EllipsoidFitReport& report) {
  return concat(sensor, ": lengths differ by ", 100 * report.rms_residual, " % (", 100 * report.rms_before,
                " % before), ", 100 * report.coverage, " % of all directions covered, ", report.outliers,
                " of ", report.readings, " readings left out");
}

Outcome run_calibrate(const CalibrateArguments& arguments) {
  Outcome outcome;
  SensorLog log;
  {
    const ScopedStage stage(outcome.times, "read");
    log = read_sensor_log(arguments.input, arguments.columns,
                          arguments.columns.empty() ? nullptr : &outcome.warnings);
  }
  DeviceCalibration device;
  {
    const ScopedStage stage(outcome.times, "fit");
    try {
      device = calibrate_device(log);
    } catch (const InvalidInput& error) {
      throw FileError(arguments.input, 0, error.what());
    }
  }
  {
    const ScopedStage stage(outcome.times, "write");
    write_calibration(device, arguments.output);
  }
  outcome.warnings = device.warnings;
  outcome.figures["readings"] = log.n_readings();
  outcome.figures["accelerometer"] = sensor_json(device.calibration.accelerometer, device.accelerometer);
  outcome.figures["magnetometer"] = sensor_json(device.calibration.magnetometer, device.magnetometer);
  const Eigen::Vector3d& bias = device.calibration.gyroscope_bias;
  outcome.figures["gyroscope"] = {{"bias", {bias.x(), bias.y(), bias.z()}},
                                  {"windows_at_rest", device.gyroscope_windows}};
  outcome.figures["alignment_deg"] = degrees(device.alignment);
  outcome.figures["inclination_deg"] = degrees(device.inclination);
  outcome.figures["output"] = arguments.output;
  outcome.lines = {
      sensor_line("accelerometer", device.accelerometer), sensor_line("magnetometer", device.magnetometer),
      concat("the magnetic field dips ", degrees(device.inclination), " degrees below the horizon"),
      concat("calibration: ", arguments.output)};
  return outcome;
}

}  // namespace

void add_calibrate(CLI::App& app) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* command =
      add_command(app, "calibrate", "Calibrate the sensors of a device from a tumbling recording",
                  "batten calibrate tumble.csv -o calibration.json",
                  [arguments](Context&) { return run_calibrate(*arguments); });
  command
      ->add_option("recording", arguments->input,
                   "Sensor log of the device turned slowly over all sides (.csv)")
      ->required();
  add_columns_option(*command, arguments->columns);
  command->add_option("-o,--output", arguments->output, "The calibration (.json)")->required();
}

}  // namespace batten::cli
