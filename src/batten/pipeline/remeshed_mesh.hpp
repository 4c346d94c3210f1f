#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/remeshing/measures.hpp"
#include "batten/remeshing/remesh.hpp"

namespace batten {

/// Options of remeshed_mesh(). The defaults are those of `batten remesh`.
struct RemeshedMeshOptions {
  RemeshOptions remesh;
  /// Edge length, above 0; relative: of the diameter of the mesh. Nothing: what `remesh.edge_length` says.
  std::optional<Length> edge_length;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// New triangles for a surface, measured. Lengths in the unit of the mesh.
struct RemeshedMesh {
  TriangleMesh mesh;  ///< without normals and values of its own
  RemeshReport report;
  MeshQuality quality;
  RemeshMeasures measures;            ///< how the surface differs from that of the input
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;
};

/// Replaces the triangles of a surface by better ones and measures what that changed: remesh(),
/// remesh_measures(), mesh_quality(). @throws InvalidInput as mesh_problem() and remesh(); Cancelled.
RemeshedMesh remeshed_mesh(const TriangleMesh& mesh, const RemeshedMeshOptions& options = {},
                           const Progress& progress = {});

}  // namespace batten
