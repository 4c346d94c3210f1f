#pragma once
#include <nlohmann/json.hpp>

namespace batten::commands {

/// Figures of a run, in the order in which --json prints them.
using Json = nlohmann::ordered_json;

/// Sets the members of one object in another.
inline void append(const Json& figures, Json& to) {
  for (const auto& [key, value] : figures.items()) to[key] = value;
}

}  // namespace batten::commands
