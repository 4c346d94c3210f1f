#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Var(E)_i: the variance of the lengths of the edges at every vertex, squared unit of the positions; zero
/// for vertices without edges. H (2.51)
Eigen::VectorXd edge_length_variances(const Points& positions, const Triangles& triangles);

/// Var(A) / (N Ā²): the variance of the vertex areas (mixed Voronoi) over their squared mean. H (2.49), which
/// leaves the division out and so depends on the unit and on the number of vertices. Zero without area.
double area_variance(const Points& positions, const Triangles& triangles);

/// How much a mesh differs from the one it was made of, as Table 2.3 of H measures it: ratios, 0 where
/// nothing changed, 1 for a change as large as the value itself.
struct MeshVariation {
  /// ΔH = ‖H − H0‖ / ‖H0‖ over the original vertices, H being that of the nearest vertex of the other mesh.
  /// Vertices on borders are left out on both sides. (2.50)
  double mean_curvature = 0;
  /// ΔVar(E) = ‖Var(E) − Var(E0)‖ / ‖Var(E0)‖, vertices matched in the same way. (2.51)
  double edge_variance = 0;
  /// |Var(A) − Var(A0)| / Var(A0) of area_variance().
  double area_variance = 0;
  /// |Var(H) − Var(H0)| / Var(H0), the variances over the vertices that are not on borders.
  double curvature_variance = 0;
};

/// A ratio whose denominator vanishes is NaN.
/// @throws InvalidInput when a mesh has no triangles, and as discrete_curvatures() where one is no manifold.
MeshVariation mesh_variation(const Points& original_positions, const Triangles& original_triangles,
                             const Points& positions, const Triangles& triangles);

}  // namespace batten
