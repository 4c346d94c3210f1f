#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Var(E)_i: the variance of the lengths of the edges at every vertex, squared unit of the positions; zero
/// for vertices without edges. H (2.51)
Eigen::VectorXd edge_length_variances(const Points& positions, const Triangles& triangles);

/// Var(A) / (N Ā²): the variance of the vertex areas (mixed Voronoi) over their squared mean. H (2.49), which
/// leaves the division out and so depends on the unit and on the number of vertices. Zero without area.
double area_variance(const Points& positions, const Triangles& triangles);

/// How much a mesh differs from the one it was made of, as Table 2.3 of H measures it: ratios, 0 where
/// nothing changed, 1 for a change as large as the value itself. Values at vertices are compared as there: at
/// every original vertex with the nearest vertex of the other mesh. A ratio to nothing (or to rounding) is
/// NaN.
struct MeshVariation {
  /// ΔH = ‖H − H0‖ / ‖H0‖. Left out are vertices on borders and those of the options, and original vertices
  /// whose nearest vertex is one of these. (2.50)
  double mean_curvature = 0;
  /// ΔVar(E) = ‖Var(E) − Var(E0)‖ / ‖Var(E0)‖ over all vertices. (2.51)
  double edge_variance = 0;
  /// |Var(A) − Var(A0)| / Var(A0) of area_variance().
  double area_variance = 0;
  /// |Var(H) − Var(H0)| / Var(H0), the variances over the vertices of each mesh that are not left out.
  double curvature_variance = 0;
};

/// How mesh_variation() counts.
struct MeshVariationOptions {
  /// One entry per vertex of either mesh, other than 0 where its curvature shall not count; empty: only
  /// borders are left out. See vertices_on_creases().
  std::vector<char> original_left_out, left_out;
  /// Take Var(E) over the squared mean edge of its mesh, so that sizes do not count; false: as (2.51) has it.
  bool relative_edges = false;

  /// The first problem found for meshes with so many vertices, naming field and value, or nothing.
  std::optional<std::string> problem(Eigen::Index n_original, Eigen::Index n_vertices) const;
};

/// @throws InvalidInput when a mesh has no triangles or an option not the size of its mesh, and as
/// discrete_curvatures() where one is no manifold; Cancelled.
MeshVariation mesh_variation(const Points& original_positions, const Triangles& original_triangles,
                             const Points& positions, const Triangles& triangles,
                             const MeshVariationOptions& options = {}, const Progress& progress = {});

/// Marks (1) the vertices on edges whose faces turn by more than `angle`, radians: there the discrete mean
/// curvature is that of the edge, in inverse proportion to the size of the triangles.
std::vector<char> vertices_on_creases(const Points& positions, const Triangles& triangles, double angle);

}  // namespace batten
