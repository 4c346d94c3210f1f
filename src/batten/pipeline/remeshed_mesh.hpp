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
  TriangleMesh mesh;  ///< with the values of the input, see carry_values()
  RemeshReport report;
  MeshQuality quality;
  RemeshMeasures measures;  ///< how the surface differs from that of the input
  /// Why the result is not what was asked for, one sentence each, with places; empty where it is. See
  /// remeshed_mesh().
  std::vector<std::string> flaws;
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;
};

/// Replaces the triangles of a surface by better ones and measures what that changed: remesh(),
/// remesh_measures(), mesh_quality().
///
/// Flaws are: more triangles that cross than in the input; half as many vertices as wanted, or less, or half
/// as many again (corners aside); a volume (of a closed input) that is off by more than 5 %. Parts of flat
/// facets (see RemeshReport::is_faceted), which have no detail to lose, are held to more: the volume to 0.5
/// %, distances either way to 2 % of the wanted edge length, the mean edge to 20 % of it (or as many
/// vertices).
/// @throws InvalidInput as mesh_problem() and remesh(); Cancelled.
RemeshedMesh remeshed_mesh(const TriangleMesh& mesh, const RemeshedMeshOptions& options = {},
                           const Progress& progress = {});

}  // namespace batten
