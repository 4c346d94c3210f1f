#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// A mesh with fewer crossings, and those that are left.
struct UncrossedMesh {
  TriangleMesh mesh;
  std::vector<std::pair<int, int>> crossings;  ///< of its triangles, as self_intersections()
  std::size_t crossings_before = 0;
};

/// Most crossings that are searched; beyond, they are no spots to be mended but a shape.
constexpr std::size_t kMostCrossings = 10000;

/// Takes out triangles that cross, with some rings of their neighbours, and fills the holes (filled_mesh()).
/// A round is kept where it leaves fewer crossings, the same number of parts, borders and handles, at
/// least 95 % of the area as it was, and the volume, where it is closed, within 0.5 %; so parts that pass
/// through each other, whose union would be another shape, stay. A mesh without crossings is returned as it
/// is.
/// @pre the mesh is manifold and oriented. @throws InvalidInput where it is not; Cancelled.
UncrossedMesh uncrossed_mesh(const TriangleMesh& mesh, const Progress& progress = {});

}  // namespace batten
