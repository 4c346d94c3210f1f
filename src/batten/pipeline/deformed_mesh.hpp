#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/deformation/deformer.hpp"
#include "batten/mesh/handles.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// Options of deformed_mesh(). The defaults are those of `batten deform`.
struct DeformedMeshOptions {
  DeformOptions deform;
  /// Iterate on a simplified mesh, put the detail back, finish on the mesh itself: see
  /// MultiresolutionDeformer. Faster from some ten thousand vertices on.
  bool multiresolution = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A mesh after its handles have moved.
struct DeformedMesh {
  TriangleMesh
      mesh;  ///< as given, with new positions; normals, where there were any, are those of the result
  std::size_t n_fixed = 0, n_moved = 0;       ///< vertices of the handles
  DeformReport report;                        ///< of the last part of the motion
  double curvature_term = 0;                  ///< see Deformer::curvature_term()
  std::optional<Eigen::Index> base_vertices;  ///< of the simplified mesh, with option `multiresolution`
  std::vector<std::string> warnings;          ///< options are named in backquotes
  StageTimes times;
};

/// Deforms a mesh by handles. Turns are made in parts of 45 degrees at most, where detail is kept: beyond
/// that the linear solution in which the iterations begin folds the surface.
/// @throws InvalidInput as mesh_problem(), Handles::problem() and Deformer; SolverFailure; Cancelled.
DeformedMesh deformed_mesh(const TriangleMesh& mesh, const Handles& handles,
                           const DeformedMeshOptions& options = {}, const Progress& progress = {});

}  // namespace batten
