#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten::detail {

using PlanePoints = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// A region of the plane: corners and closed loops over them, the region to the left of every loop. A corner
/// may be passed more than once (slits).
struct PlaneRegion {
  PlanePoints corners;
  std::vector<std::vector<int>> loops;
};

/// Bounds of the triangles (S 4.4.2).
struct TessellationOptions {
  double min_angle = 20 * 3.14159265358979323846 / 180;  ///< radians
  double max_area = 0;                                   ///< square of the unit of the corners
  int smoothing_rounds = 3;  ///< rounds that even out the triangles; 0 leaves the refinement as it is
};

/// Triangles over a region. The corners are the first vertices, in their order; loops are never split.
struct Tessellation {
  bool valid = false;   ///< false: the region folds over, see `problem`
  std::string problem;  ///< half a sentence
  PlanePoints vertices;
  Triangles triangles;
};

/// Constrained Delaunay triangulation with Steiner points inside (S 4.4.2). The same corners in the same
/// order give the same triangles on every machine.
Tessellation tessellate(const PlaneRegion& region, const TessellationOptions& options);

}  // namespace batten::detail
