#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>

#include "batten/core/error.hpp"
#include "batten/io/zip_archive.hpp"
#include "batten/session/project.hpp"

namespace {

/// The entries of a project, each behind a line "@@ name". Packed here, so that their check sums are right
/// and what is behind them is reached.
std::map<std::string, std::string> entries_of(const std::string& text) {
  std::map<std::string, std::string> entries;
  for (std::size_t at = text.find("@@ "); at != std::string::npos;) {
    const std::size_t line = text.find('\n', at), next = text.find("\n@@ ", at);
    if (line == std::string::npos) break;
    const std::size_t end = next == std::string::npos ? text.size() : next;
    entries[text.substr(at + 3, line - at - 3)] =
        line < end ? text.substr(line + 1, end - line - 1) : std::string();
    at = next == std::string::npos ? next : next + 1;
  }
  return entries;
}

/// A document that reads back as it is written, or a sentence about the file.
void read(const std::string& bytes) {
  try {
    const std::string written = batten::format_project(batten::parse_project(bytes, "input.batten").document);
    if (batten::format_project(batten::parse_project(written, "written.batten").document) != written)
      std::abort();
  } catch (const batten::FileError&) {
    // The expected answer to broken input; anything else ends the run.
  }
}

}  // namespace

/// Whatever the bytes: as the archive itself, and as what an archive holds.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  read(text);
  read(batten::format_archive(entries_of(text)));
  return 0;
}
