#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Curvatures per vertex. H = (κ1 + κ2)/2 is positive on a sphere with outward normals
/// (docs/methods.md#conventions).
struct Curvatures {
  /// M⁻¹K x = 2 H N, n × 3. S (2.38), H (1.28). At a border it holds the pull of the open side as well.
  Points mean_vector;
  Eigen::VectorXd mean;         ///< H, 1/length; sign by the vertex normals
  Eigen::VectorXd gaussian;     ///< K: angle deficit over area (π instead of 2π on a border), 1/length²
  Eigen::VectorXd maximal;      ///< κ1 = H + √(H² − K), the root taken as 0 where it is not real
  Eigen::VectorXd minimal;      ///< κ2
  std::vector<char> on_border;  ///< there the values are no estimates of curvature
};
/// By cotangents and mixed Voronoi areas. Vertices without triangles get zeros.
Curvatures discrete_curvatures(const Points& positions, const Triangles& triangles);

/// 2 H N, n × 3, as minus the divergence of the gradient of the positions, both per vertex: H (1.29) turned
/// to the sign of Curvatures::mean_vector (the printed form gives −2 H N). Its stencil is the two-ring, so
/// noise shows less in it and detail too; flat parts of a border get no pull.
Points curvature_from_divergence(const Points& positions, const Triangles& triangles);

/// Sum of the angle deficits 2π − Σ angles, π − Σ angles on borders: 2π χ exactly (Gauss-Bonnet).
double total_angle_deficit(const Points& positions, const Triangles& triangles);

/// Vertices on a border, and the error of opposite_half_edges() where the mesh is no manifold.
std::vector<char> border_vertices(const Triangles& triangles, Eigen::Index n_vertices);

/// Integrated mean curvature from normals that need not be those of the triangles (S (4.18) before the
/// division by A_v): row v is ½ Σ (x_{i+1} − x_i) × n_T over the triangles around v, with n_T the normalised
/// sum of the three corner normals. It estimates −2 H N times the area around v.
Points integrated_curvature_from_normals(const Points& positions, const Points& normals,
                                         const Triangles& triangles);

}  // namespace batten
