#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/mending.hpp"
#include "batten/surfacing/hole_filling.hpp"

namespace batten {

/// Options of repaired_mesh(). The defaults are those of `batten repair`.
struct RepairedMeshOptions {
  bool weld = true;  ///< weld borders that lie on each other
  /// Distance up to which they are welded, at least 0; relative: of the diameter of the mesh. Nothing: as
  /// the mesh suggests, see weld_borders().
  std::optional<Length> weld_length;
  /// Turn every closed part so that all together bound a volume, see MendingOptions::orient.
  bool orient = false;
  /// Fill holes of at most this many edges; 0: none, kAllHoles: all, outlines of open surfaces too.
  int fill_holes = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A mesh that every other request takes, and what was wrong with it.
struct RepairedMesh {
  TriangleMesh mesh;  ///< manifold, oriented, without triangles that have no area and unused vertices
  MeshTopology topology;
  MendingReport mended;
  std::vector<MeshHole> holes;        ///< after mending, those that were filled and those that are left
  std::size_t crossings_removed = 0;  ///< pairs of triangles that crossed and do no longer
  /// Pairs of triangles of the result that cross each other; up to kMostListedIntersections of them.
  std::vector<std::pair<int, int>> crossings;
  std::optional<double> volume;       ///< enclosed; nothing where the mesh is not closed
  std::vector<std::string> done;      ///< what was mended, a line for each kind
  std::vector<std::string> flaws;     ///< what could not be mended, with places; empty for a sound result
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;

  /// How many of the holes were filled.
  int n_filled() const;
};

/// Mends a mesh: mended_mesh(), uncrossed_mesh(), filled_mesh(). One without fault is returned as it is.
/// @throws InvalidInput on bad options, without faces, on numbers that are not finite and indices out of
/// range, with the place; Cancelled.
RepairedMesh repaired_mesh(const TriangleMesh& mesh, const RepairedMeshOptions& options = {},
                           const Progress& progress = {});

/// Welds a mesh that is a soup of triangles, as STL files hold them (is_triangle_soup()); others stay as they
/// are. @return what was done, in words, or nothing. @throws InvalidInput on an index out of range.
std::optional<std::string> weld_soup(TriangleMesh& mesh);

}  // namespace batten
