#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/simplification/simplify.hpp"

namespace batten {

/// Options of simplified_mesh(). The defaults are those of `batten simplify`; one criterion must be given.
struct SimplifiedMeshOptions {
  SimplifyOptions simplify;
  /// The criterion `simplify.max_error` as a length, above 0; relative: of the diameter of the mesh.
  std::optional<Length> max_error;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A mesh with fewer faces, held against the one it was made of. Lengths in the unit of the mesh.
struct SimplifiedMesh {
  /// Its mesh has the values of the input, see carry_values(); its warnings and times have been moved to
  /// those below.
  SimplifyResult simplified;
  double diameter = 0;                ///< of the input
  double removed = 0;                 ///< share of the faces
  Comparison distances;               ///< A is the input, B the result
  MeshQuality quality;                ///< of the result
  std::size_t input_crossings = 0;    ///< pairs of triangles of the input that cross, 1000 at most
  std::size_t crossings = 0;          ///< of the result
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;
};

/// Reduces the number of faces and measures the result: simplify(), compare(), mesh_quality(),
/// self_intersections(). @throws InvalidInput as mesh_problem() and simplify(); Cancelled.
SimplifiedMesh simplified_mesh(const TriangleMesh& mesh, const SimplifiedMeshOptions& options,
                               const Progress& progress = {});

/// The meshes of all levels from the input on; all but the last hold, per vertex, the vertex of the next
/// coarser level that stands for it ("coarser_vertex"; −1 where no face used it), and no other values.
/// @pre `levels` was made of `input` (SimplifyOptions::keep_levels).
std::vector<TriangleMesh> level_meshes(const TriangleMesh& input, const std::vector<SimplifyLevel>& levels);

}  // namespace batten
