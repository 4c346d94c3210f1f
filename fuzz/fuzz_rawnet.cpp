#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/io/scan_io.hpp"

/// Whatever the bytes: a scan that passes its checks, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const batten::Scan scan = batten::parse_rawnet(std::string(data, data + size), "input.rawnet");
    batten::check_scan(scan);
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
  return 0;
}
