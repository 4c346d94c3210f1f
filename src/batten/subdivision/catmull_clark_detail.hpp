#pragma once
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

// What the one source that uses OpenSubdiv offers. Private to the room.
namespace batten::detail {

/// Catmull–Clark refinement. Fills everything of the result but what is left sharp.
void refine_catmull_clark(const ControlCage& cage, const CageTopology& topology,
                          const SubdivisionOptions& options, SubdividedSurface& surface,
                          const Progress& progress);

/// A bicubic piece of the limit surface of an all-quad cage: the cell of side 2^−depth at (u, v) of the unit
/// square of a face, u from its corner 0 to 1, v from 0 to 3.
struct LimitCell {
  int face = 0;
  int depth = 0;
  int u = 0, v = 0;                             // in units of the cell's side
  Eigen::Matrix<double, 16, 3> control_points;  // uniform bicubic B-spline, index 4 j + i, i along u
};

/// The limit surface of an all-quad cage without semi-sharp features: exact cells down to `depth`, all of it
/// but the cells of that depth at irregular vertices.
struct LimitCells {
  std::vector<LimitCell> cells;
  Points vertex_positions, vertex_normals;  // of the limit surface, at the vertices of the cage
};
LimitCells limit_cells(const ControlCage& cage, const CageTopology& topology, int depth, bool smooth_corners);

}  // namespace batten::detail
