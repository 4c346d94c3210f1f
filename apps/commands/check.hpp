#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/pipeline/checked_curves.hpp"

namespace batten::commands {

/// Options of `check` in the words of users, with their defaults (docs/check.md).
struct CheckArguments {
  std::string continuity = "g1", tolerance = "0.5deg";
  double gap = 0.1, curvature = 10, distance = 1;  // per cent
};

/// @throws InvalidInput on words that do not parse and on values out of range.
CurveCheckOptions options_of(const CheckArguments& arguments);

/// All but what surface and network are.
Json figures_of(const CurveCheck& check);

}  // namespace batten::commands
