#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/pipeline/simplified_mesh.hpp"

namespace batten::commands {

/// Options of `simplify` in the words of users, with their defaults (docs/simplify.md).
struct SimplifyArguments {
  std::string remove, error, method = "quadric", weight = "w3", fidelity = "adaptive";
  std::string keep_edges = "off", keep_border = "shape";
  long faces = 0;
  int levels = 3;
  bool keep_all_levels = false;
  bool repair = false;
  double p = 0.1, alpha = 1, beta = 1, sigma = 0.5;
};

/// Those of single options; the sentences go on behind the name of the option. @throws InvalidInput.
double parse_removed_fraction(const std::string& text);
Length parse_error_length(const std::string& text);
std::optional<double> parse_fidelity(const std::string& text);
double parse_kept_angle(const std::string& text);

/// @throws UsageError unless exactly one criterion is given; InvalidInput on words that do not parse.
SimplifiedMeshOptions options_of(const SimplifyArguments& arguments);

/// @param input the mesh that was simplified.
Json figures_of(const TriangleMesh& input, const SimplifiedMesh& result);

}  // namespace batten::commands
