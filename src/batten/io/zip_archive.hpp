#pragma once
#include <map>
#include <string>

// Zip files whose entries are not compressed: those of projects, and 3MF.
namespace batten {

/// The bytes of a zip file, entries in the order of their names, without times, so that equal content gives
/// equal bytes. @pre each entry is smaller than 4 GiB, and so is the whole.
std::string format_archive(const std::map<std::string, std::string>& entries);

/// @throws InvalidInput when the bytes are no zip file, are cut off or damaged, or an entry is compressed.
std::map<std::string, std::string> parse_archive(const std::string& bytes);

}  // namespace batten
