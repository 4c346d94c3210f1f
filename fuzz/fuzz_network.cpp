#include <cstdint>
#include <string>

#include "batten/core/error.hpp"
#include "batten/io/network_io.hpp"

/// Whatever the bytes, under every extension: a network that can be written, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string content(data, data + size);
  for (const char* name : {"input.net", "input.obj", "input.json", "input.txt", "input.lop"}) {
    try {
      const batten::CurveNetwork network = batten::parse_network(content, name);
      batten::network_topology(network);
      batten::format_network(network, batten::NetworkFormat::Json);
    } catch (const batten::FileError&) {
      // The expected answer to broken input; anything else ends the run.
    }
  }
  return 0;
}
