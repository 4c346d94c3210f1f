#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/pipeline/remeshed_mesh.hpp"

namespace batten::commands {

/// Options of `remesh` in the words of users, with their defaults (docs/remesh.md).
struct RemeshArguments {
  std::string edge, keep_edges = "30deg", keep_border = "curve", method = "ar", sizes;
  int vertices = 0, iterations = RemeshOptions{}.max_iterations;
  double adaptivity = RemeshOptions{}.adaptivity;
  bool repair = false;
  bool accept_flaws = false;
};

/// @param name what sentences call the mesh. @throws InvalidInput on words that do not parse, and where the
/// mesh has no values of the name `sizes`.
RemeshedMeshOptions options_of(const RemeshArguments& arguments, const TriangleMesh& mesh,
                               const std::string& name);

Json figures_of(const RemeshedMesh& result);

}  // namespace batten::commands
