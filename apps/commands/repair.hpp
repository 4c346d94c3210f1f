#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/pipeline/repaired_mesh.hpp"

namespace batten::commands {

/// Options of `repair` in the words of users, with their defaults (docs/repair.md).
struct RepairArguments {
  std::string weld = "auto", fill_holes = "0";
  bool orient = false, accept_flaws = false;
};

/// @throws InvalidInput on words that do not parse.
RepairedMeshOptions options_of(const RepairArguments& arguments);

/// @param input the mesh that was repaired.
Json figures_of(const TriangleMesh& input, const RepairedMesh& repaired);

}  // namespace batten::commands
