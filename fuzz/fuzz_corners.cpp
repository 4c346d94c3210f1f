#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/io/file.hpp"
#include "batten/io/rig_io.hpp"

/// Whatever the bytes: corners of the board inside their images, or a sentence about the file. What can be
/// read is calibrated from: that ends with a rig without problems, or a refusal.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const batten::CornersOptions options{.board = {.columns = 4, .rows = 3, .square = 0.02}, .size = {}};
  batten::BoardPairs pairs;
  try {
    pairs = batten::parse_corners(std::string(data, data + size), "input.csv", options);
    if (batten::problem(pairs)) std::abort();
  } catch (const batten::FileError&) {
    return 0;  // The expected answer to broken input; anything else ends the run.
  }
  try {
    const batten::RigCalibration found = batten::calibrate_rig(pairs, {.lens = batten::LensModel::Radial});
    if (!batten::problem(found.calibrated.rig).empty()) std::abort();
  } catch (const batten::InvalidInput&) {
    return 0;  // Too few pairs, most often.
  }
  return 0;
}
