#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/fairing/fair.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// A mesh without its noise, and what that changed.
struct FairedMesh {
  TriangleMesh
      mesh;  ///< as given, with new positions; normals, where there were any, are those of the result
  MeshTopology topology;
  std::optional<FairingStrategy> strategy;  ///< what the automatic method took; nothing for the others
  double noise = 0;                         ///< in mean edge lengths, given or estimated
  int iterations = 0;                       ///< rounds or steps taken
  double time_step = 0;                     ///< of the flows, else 0
  double largest_move = 0;                  ///< in the unit of the mesh
  double mean_normal_change = 0;            ///< radians; see mean_normal_angle()
  std::optional<double>
      volume_change;    ///< (V' − V) / V; nothing where the mesh is not closed or encloses nothing
  SolveQuality solves;  ///< the iterative ones; zeros for methods without
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;
};

/// Removes noise from a mesh: fair(), with what it changed. The options are those of `batten fair`.
/// @throws InvalidInput as mesh_problem() and fair(); SolverFailure; Cancelled.
FairedMesh faired_mesh(const TriangleMesh& mesh, const FairingOptions& options = {},
                       const Progress& progress = {});

}  // namespace batten
