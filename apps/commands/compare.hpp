#pragma once
#include "commands/json.hpp"

#include <cstdint>
#include <string>

#include "batten/pipeline/shape_comparison.hpp"

namespace batten::commands {

/// Options of `compare` in the words of users, with their defaults (docs/compare.md).
struct CompareArguments {
  std::string registration = "none";
  std::uint64_t seed = 1;
  long samples = 200000;
  bool repair = false;
};

/// @throws InvalidInput on words that do not parse.
CompareOptions options_of(const CompareArguments& arguments);

/// All but what the shapes are.
Json figures_of(const CompareArguments& arguments, const ShapeComparison& compared);

/// What `--against` adds to the figures of something made: "error_percent".
Json figures_of(const TruthErrors& errors);

}  // namespace batten::commands
