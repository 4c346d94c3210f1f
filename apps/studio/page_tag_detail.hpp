#pragma once
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace batten::studio {

/// Sixteen digits that tell contents of a page apart (FNV-1a). No protection against whoever wants two alike.
inline std::string content_tag(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace batten::studio
