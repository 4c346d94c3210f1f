#pragma once
#include <utility>
#include <vector>

#include "batten/core/arrays.hpp"

namespace batten {

/// The shapes of the triangles of a mesh. Angles in radians, lengths in the unit of the positions. Zero
/// everywhere for a mesh without triangles.
struct MeshQuality {
  double min_angle = 0;       ///< smallest of all
  double mean_min_angle = 0;  ///< mean over the triangles of their smallest angle; π/3 is best
  double max_angle = 0;       ///< largest of all
  double slivers = 0;         ///< share of the triangles with an angle below 20°
  /// Circumradius over twice the inradius: 1 for an equilateral triangle, infinite without area.
  double mean_aspect = 0, max_aspect = 0;
  double min_edge = 0, mean_edge = 0, max_edge = 0;
  int worst_triangle = -1;  ///< that of max_aspect
};

/// @pre the indices are in range, as for all functions of this header.
MeshQuality mesh_quality(const Points& positions, const Triangles& triangles);

/// Share of the vertices inside the surface at which six edges meet, 0 without any. Vertices on borders and
/// those of edges with more than two triangles are left out.
double regular_share(const Triangles& triangles, Eigen::Index n_vertices);

/// Triangles so flat that their normal means nothing: height at most `tolerance` times the longest side. Also
/// those with two corners at the same place.
/// @param tolerance relative; 1e-9 is far above the rounding of coordinates given with 12 digits.
std::vector<int> degenerate_triangles(const Points& positions, const Triangles& triangles,
                                      double tolerance = 1e-9);

/// Triangles whose normal points against the surface: at most a right angle from the sum of the normals given
/// at their corners (n × 3). Triangles without area are left out.
std::vector<int> folded_triangles(const Points& positions, const Triangles& triangles,
                                  const Points& vertex_normals);

/// Pairs of triangles on both sides of an edge (counted once, by edge order) whose normals differ by more
/// than `max_angle` radians: the surface folds back there. Edges of one or of more than two triangles are
/// left out.
std::vector<std::pair<int, int>> folded_edges(const Points& positions, const Triangles& triangles,
                                              double max_angle);

}  // namespace batten
