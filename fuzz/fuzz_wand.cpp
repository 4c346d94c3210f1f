#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/core/error.hpp"
#include "batten/io/wand_io.hpp"

/// Whatever the bytes: frames of both cameras, in the order of time, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto frames = batten::parse_wand(std::string(data, data + size), "input.jsonl");
    if (frames.empty()) std::abort();
    for (std::size_t i = 1; i < frames.size(); ++i)
      if (frames[i].time < frames[i - 1].time) std::abort();
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
  return 0;
}
