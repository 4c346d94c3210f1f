#pragma once
#include <string>
#include <vector>

#include "batten/session/object.hpp"

namespace batten {

/// An object as the bytes of a file.
struct SavedFile {
  std::string bytes;
  std::vector<std::string> warnings;  ///< what the format cannot hold
};

/// The formats that an object of a kind can be saved in, by their extensions, the best first; empty for
/// models and views, which projects hold.
std::vector<std::string> formats_of(ObjectKind kind);

/// @param unit of the object's lengths, for formats whose lengths have one; empty stands for metres.
/// @throws InvalidInput naming the formats where the object cannot be saved in this one.
SavedFile save_file(const Content& content, const std::string& extension, const std::string& unit);

}  // namespace batten
