#include <cmath>

#include <Eigen/LU>

#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/json_reader_detail.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace batten {

namespace {

using detail::JsonReader;
using OrderedJson = JsonReader::Json;

constexpr const char* kCalibrationFormat = "batten calibration";

OrderedJson sensor_json(const SensorCalibration& sensor, const EllipsoidFitReport& report, const char* unit) {
  return {{"unit", unit},
          {"offset", JsonReader::list(sensor.offset)},
          {"matrix", JsonReader::list(sensor.matrix)},
          {"radius", report.radius},
          {"rms_residual", report.rms_residual},
          {"coverage", report.coverage},
          {"readings", report.readings},
          {"outliers", report.outliers}};
}

SensorCalibration read_sensor(const JsonReader& reader, const OrderedJson& document,
                              const std::string& name) {
  const OrderedJson& object = reader.member(document, name, "");
  SensorCalibration sensor;
  sensor.offset = reader.vector(reader.member(object, "offset", name + "."), name + ".offset");
  sensor.matrix = reader.matrix(reader.member(object, "matrix", name + "."), name + ".matrix");
  if (!(std::abs(sensor.matrix.determinant()) > 1e-6 * std::pow(sensor.matrix.norm(), 3)))
    reader.fail(name + ".matrix is singular; calibrate the device again");
  return sensor;
}

}  // namespace

Calibration read_calibration(const std::string& path) {
  return parse_calibration(read_file(path), path);
}

Calibration parse_calibration(const std::string& text, const std::string& name) {
  const JsonReader reader(name, "write the file with batten calibrate");
  const OrderedJson document = reader.parse(text);
  if (!document.is_object() || document.value("format", OrderedJson()) != kCalibrationFormat)
    reader.fail(
        "is no calibration: expected \"format\": \"batten calibration\"; write it with batten calibrate");
  Calibration calibration;
  calibration.accelerometer = read_sensor(reader, document, "accelerometer");
  calibration.magnetometer = read_sensor(reader, document, "magnetometer");
  const OrderedJson& gyroscope = reader.member(document, "gyroscope", "");
  calibration.gyroscope_bias =
      reader.vector(reader.member(gyroscope, "bias", "gyroscope."), "gyroscope.bias");
  return calibration;
}

void write_calibration(const DeviceCalibration& device, const std::string& path) {
  OrderedJson document = {
      {"format", kCalibrationFormat},
      {"version", 1},
      {"meaning", "calibrated = matrix * (raw - offset), in the unit of the sensor, device axes"}};
  document["accelerometer"] = sensor_json(device.calibration.accelerometer, device.accelerometer, "m/s^2");
  document["magnetometer"] = sensor_json(device.calibration.magnetometer, device.magnetometer, "uT");
  document["gyroscope"] = {{"unit", "rad/s"},
                           {"bias", JsonReader::list(device.calibration.gyroscope_bias)},
                           {"windows_at_rest", device.gyroscope_windows}};
  document["alignment_deg"] = degrees(device.alignment);
  document["inclination_deg"] = degrees(device.inclination);
  write_file(path, document.dump(2) + "\n");
}

}  // namespace batten
