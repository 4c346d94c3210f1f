#pragma once
#include <array>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten::detail {

/// A side that quads of a layout share, or one on the border.
struct LayoutEdge {
  std::array<int, 2> corners{-1, -1};  ///< its direction
  std::array<int, 2> quads{-1, -1};    ///< the second −1 on the border
  std::array<int, 2> sides{-1, -1};    ///< which side of each quad
  bool is_sharp = false;
};

/// Corners counter-clockwise seen from outside; side k runs from corner k to corner k + 1.
struct LayoutQuad {
  std::array<int, 4> corners{};
  std::array<int, 4> edges{};
  int patch = 0;  ///< in which it lies
};

/// A point of the mesh in the unit square of a quad, whose corners are (0, 0), (1, 0), (1, 1), (0, 1).
struct LayoutSample {
  int point = 0, quad = 0;
  double u = 0, v = 0;
};

/// Quads that cover the patches of a mesh and meet side to side.
struct QuadLayout {
  int n_corners = 0;
  std::vector<LayoutEdge> edges;
  std::vector<LayoutQuad> quads;
  Points points;                ///< the vertices, and points inside the triangles of patches that have few
  Eigen::Index n_vertices = 0;  ///< of these, the first
  std::vector<LayoutSample> samples;  ///< every point once, those between patches once for each
};

/// Divides the patches of a mesh into quads. A patch with four corners is one quad; one with more or less is
/// divided around its middle; where curves run straight through its nodes, or it has less than three corners,
/// a ring of quads along its outline keeps the angles at the nodes halves of those they had. Patches of
/// several outlines are cut along shortest paths first.
/// @param patch_of_triangle  one number per triangle of the mesh, which must be an oriented manifold.
/// @param crease_angle  curves at which the surface turns by more in the median, radians, are sharp.
/// @throws InvalidInput naming a patch that has handles, no outline, or too few vertices to be divided.
QuadLayout quad_layout(const Points& positions, const Triangles& triangles,
                       const std::vector<int>& patch_of_triangle, double crease_angle,
                       const Progress& progress);

}  // namespace batten::detail
