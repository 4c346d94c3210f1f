#pragma once
#include "commands/json.hpp"

#include <string>
#include <vector>

#include "batten/pipeline/subdivided_cage.hpp"

namespace batten::commands {

/// Options of `subdivide` for its mesh in the words of users, with their defaults (docs/subdivide.md).
struct SubdivideArguments {
  std::string scheme = "catmull-clark", corners = "sharp";
  int levels = 3;
  double knots = 0.5;
  bool limit = false;
};

/// The schemes of a list such as "nulissmod,catmull-clark". @throws InvalidInput.
std::vector<SubdivisionScheme> parse_schemes(const std::string& text);

/// @throws InvalidInput on words that do not parse.
SubdividedCageOptions options_of(const SubdivideArguments& arguments);

/// Of the cage, and of what was refined.
Json figures_of(const SubdividedCage& result);

}  // namespace batten::commands
