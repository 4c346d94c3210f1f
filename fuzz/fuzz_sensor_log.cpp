#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/io/file.hpp"
#include "batten/io/sensor_log_io.hpp"

/// Whatever the bytes: a log that can be turned into a scan or is refused in words, or a sentence about the
/// file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  batten::SensorLog log;
  try {
    log = batten::parse_sensor_log(std::string(data, data + size), "input.csv");
  } catch (const batten::FileError&) {
    return 0;
  }
  try {
    batten::scan_from_log(log);
  } catch (const batten::InvalidInput&) {
    // Curves without readings, no magnetometer, and the like.
  }
  try {
    batten::calibrate_device(log);
  } catch (const batten::InvalidInput&) {
    // Too few readings for a calibration.
  }
  return 0;
}
