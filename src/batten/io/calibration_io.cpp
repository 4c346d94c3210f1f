#include <cmath>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace batten {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "batten calibration";

Json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json sensor_json(const SensorCalibration& sensor, const EllipsoidFitReport& report, const char* unit) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back(vector_json(sensor.matrix.row(i).transpose()));
  return {{"unit", unit},
          {"offset", vector_json(sensor.offset)},
          {"matrix", rows},
          {"radius", report.radius},
          {"rms_residual", report.rms_residual},
          {"coverage", report.coverage},
          {"readings", report.readings},
          {"outliers", report.outliers}};
}

/// Takes entries out of the document; every error names its place.
class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  const Json& member(const Json& object, const std::string& key, const std::string& where) const {
    if (!object.is_object() || !object.contains(key))
      fail(concat(where, key, " is missing; write the file with batten calibrate"));
    return object.at(key);
  }

  Eigen::Vector3d vector(const Json& value, const std::string& where) const {
    if (!value.is_array() || value.size() != 3) fail(concat(where, " must be a list of 3 numbers"));
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) {
      const Json& entry = value[static_cast<size_t>(k)];
      if (!entry.is_number()) fail(concat(where, " must be a list of 3 numbers"));
      v[k] = entry.get<double>();
    }
    if (!v.allFinite()) fail(concat(where, " must be finite"));
    return v;
  }

  SensorCalibration sensor(const Json& document, const std::string& name) const {
    const Json& object = member(document, name, "");
    SensorCalibration sensor;
    sensor.offset = vector(member(object, "offset", name + "."), name + ".offset");
    const Json& rows = member(object, "matrix", name + ".");
    if (!rows.is_array() || rows.size() != 3) fail(name + ".matrix must be a list of 3 rows of 3 numbers");
    for (int i = 0; i < 3; ++i)
      sensor.matrix.row(i) = vector(rows[static_cast<size_t>(i)], concat(name, ".matrix[", i, "]"));
    if (!(std::abs(sensor.matrix.determinant()) > 1e-6 * std::pow(sensor.matrix.norm(), 3)))
      fail(name + ".matrix is singular; calibrate the device again");
    return sensor;
  }

  [[noreturn]] void fail(const std::string& problem) const { throw FileError(path_, 0, problem); }

 private:
  std::string path_;
};

}  // namespace

Calibration read_calibration(const std::string& path) {
  return parse_calibration(read_file(path), path);
}

Calibration parse_calibration(const std::string& text, const std::string& name) {
  const Reader reader(name);
  Json document;
  try {
    document = Json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    reader.fail(concat("is not valid JSON near byte ", error.byte, "; write the file with batten calibrate"));
  } catch (const nlohmann::json::exception&) {  // numbers beyond the range of double
    reader.fail("holds a number that is out of range; write the file with batten calibrate");
  }
  if (!document.is_object() || document.value("format", Json()) != kFormat)
    reader.fail(
        "is no calibration: expected \"format\": \"batten calibration\"; write it with batten calibrate");
  Calibration calibration;
  calibration.accelerometer = reader.sensor(document, "accelerometer");
  calibration.magnetometer = reader.sensor(document, "magnetometer");
  const Json& gyroscope = reader.member(document, "gyroscope", "");
  calibration.gyroscope_bias =
      reader.vector(reader.member(gyroscope, "bias", "gyroscope."), "gyroscope.bias");
  return calibration;
}

void write_calibration(const DeviceCalibration& device, const std::string& path) {
  Json document = {
      {"format", kFormat},
      {"version", 1},
      {"meaning", "calibrated = matrix * (raw - offset), in the unit of the sensor, device axes"}};
  document["accelerometer"] = sensor_json(device.calibration.accelerometer, device.accelerometer, "m/s^2");
  document["magnetometer"] = sensor_json(device.calibration.magnetometer, device.magnetometer, "uT");
  document["gyroscope"] = {{"unit", "rad/s"},
                           {"bias", vector_json(device.calibration.gyroscope_bias)},
                           {"windows_at_rest", device.gyroscope_windows}};
  document["alignment_deg"] = degrees(device.alignment);
  document["inclination_deg"] = degrees(device.inclination);
  write_file(path, document.dump(2) + "\n");
}

}  // namespace batten
