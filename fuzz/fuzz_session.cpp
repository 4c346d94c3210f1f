#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/session/journal.hpp"

/// Whatever the bytes: edits that read back as they are written, or a sentence about the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    std::vector<batten::Edit> edits;
    for (const batten::SessionEdit& edit :
         batten::parse_session(std::string(data, data + size), "input.jsonl").edits)
      edits.push_back(edit.edit);
    const std::string written = batten::format_session(edits);
    edits.clear();
    for (const batten::SessionEdit& edit : batten::parse_session(written, "written.jsonl").edits)
      edits.push_back(edit.edit);
    if (batten::format_session(edits) != written) std::abort();
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
  return 0;
}
