#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/io/file.hpp"
#include "batten/io/log_columns.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace {

/// A log that can be turned into a scan or is refused in words, or a sentence about the file.
void read_log(const std::string& text, const std::string& columns) {
  batten::SensorLog log;
  try {
    log = batten::parse_sensor_log(text, "input.csv", columns);
  } catch (const batten::FileError&) {
    return;
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
}

}  // namespace

/// Whatever the bytes, with our own columns and with guessed ones; the first line is a description of columns
/// too.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  read_log(text, {});
  read_log(text, "auto");
  try {
    const batten::LogColumns columns = batten::parse_log_columns(text.substr(0, text.find('\n')));
    const std::string written = batten::format_log_columns(columns);
    if (batten::format_log_columns(batten::parse_log_columns(written)) != written) std::abort();
  } catch (const batten::InvalidInput&) {
    // No description.
  }
  return 0;
}
