#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/pipeline/deformed_mesh.hpp"

namespace batten::commands {

/// Options of `deform` in the words of users, with their defaults (docs/deform.md).
struct DeformArguments {
  std::string energy = "total", nonlinear = "gauss-newton";
  double soft = 0;
  int iterations = DeformOptions{}.max_iterations;
  bool multiresolution = false;
  bool repair = false;
};

/// @throws InvalidInput on words that do not parse.
DeformedMeshOptions options_of(const DeformArguments& arguments);

Json figures_of(const DeformedMesh& result);

}  // namespace batten::commands
