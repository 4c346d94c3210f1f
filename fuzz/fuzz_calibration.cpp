#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/io/file.hpp"
#include "batten/io/sensor_log_io.hpp"

/// Whatever the bytes: a calibration, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    batten::parse_calibration(std::string(data, data + size), "input.json");
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
  return 0;
}
