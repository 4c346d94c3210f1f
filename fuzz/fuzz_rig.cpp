#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/io/file.hpp"
#include "batten/io/rig_io.hpp"

/// Whatever the bytes: a rig without problems, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const batten::CalibratedRig rig = batten::parse_rig(std::string(data, data + size), "input.json");
    if (!batten::problem(rig.rig).empty()) std::abort();
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
  return 0;
}
