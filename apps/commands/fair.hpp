#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/pipeline/faired_mesh.hpp"

namespace batten::commands {

/// Options of `fair` in the words of users, with their defaults (docs/fair.md).
struct FairArguments {
  std::string method = "auto", noise = "auto";
  int iterations = 0;
  bool keep_boundary = false;
  bool repair = false;
};

/// The noise in mean edge lengths; −1 for "auto". @throws InvalidInput on anything else.
double parse_noise(const std::string& text);

/// @throws InvalidInput on words that do not parse.
FairingOptions options_of(const FairArguments& arguments);

/// The word of what was done: that of the method, or of what the automatic method took.
std::string strategy_of(const FairArguments& arguments, const FairedMesh& faired);

Json figures_of(const FairArguments& arguments, const FairedMesh& faired);

}  // namespace batten::commands
