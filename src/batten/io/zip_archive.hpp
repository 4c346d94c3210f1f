#pragma once
#include <map>
#include <string>

// Zip files: those of projects, and 3MF. They are written without compression.
namespace batten {

/// The bytes of a zip file, entries in the order of their names, without times, so that equal content gives
/// equal bytes. @pre each entry is smaller than 4 GiB, and so is the whole.
std::string format_archive(const std::map<std::string, std::string>& entries);

/// The content of all entries, which may be stored or deflated (in the browser: stored only).
/// @throws InvalidInput when the bytes are no zip file, are cut off or damaged, an entry is packed otherwise,
/// or unpacks to more than a hundred times its size and 64 MB.
std::map<std::string, std::string> parse_archive(const std::string& bytes);

}  // namespace batten
