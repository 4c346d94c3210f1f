#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace batten {

/// What the elements of an array are; little-endian, as the arrays of a page are on every machine it runs on.
enum class ElementType { Float32, Uint32, Uint8 };

/// One array of a reply, beside its JSON: "positions" with 3 columns.
struct ReplyArray {
  std::string name;
  ElementType type = ElementType::Float32;
  int columns = 1;  ///< elements of one entry
  std::vector<std::byte> bytes;
};

/// What a message gives back.
struct Reply {
  /// A JSON object: {"ok":true, …} or {"ok":false,"kind":…,"message":…,"remedy":…}; the remedy only where
  /// there is one. See docs/engine.md.
  std::string text;
  std::vector<ReplyArray> arrays;
};

}  // namespace batten
