#pragma once
#include <string>

// Private to the room: files that must be there after a crash.
namespace batten::detail {

/// As write_file(), but the content is on the disk before it takes its place: also when the computer dies,
/// the old file or the new one is there. A few milliseconds. @throws FileError.
void write_durably(const std::string& path, const std::string& content);

}  // namespace batten::detail
