#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/core/error.hpp"
#include "batten/io/handles_io.hpp"

/// Whatever the bytes: handles of vertices that there are, each in one of them, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  batten::Points positions(27, 3);  // a lattice, so that boxes and spheres hold some
  for (int i = 0; i < 27; ++i) positions.row(i) << i % 3, i / 3 % 3, i / 9;
  try {
    const batten::Handles handles =
        batten::parse_handles(std::string(data, data + size), "input.json", positions);
    if (handles.problem(static_cast<int>(positions.rows()))) std::abort();
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
  return 0;
}
