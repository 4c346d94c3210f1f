#pragma once
#include "batten/core/progress.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// How a remeshed surface differs from the original: the five measures of H, table 2.3, and the error of its
/// normals. The first four are those of mesh_variation(), without creases, with 0 for a ratio to nothing.
struct RemeshMeasures {
  double curvature_change = 0;  ///< ΔH = ‖H − H0‖ / ‖H0‖ (2.50)
  /// ΔVar(E) = ‖Var(E) − Var(E0)‖ / ‖Var(E0)‖ (2.51), each over the squared mean edge of its mesh.
  double edge_variance_change = 0;
  /// ΔVar(A) = |Var(A) − Var(A0)| / Var(A0), with (2.49) over Nv Ā²: as printed it grows with the unit and
  /// the number of vertices.
  double area_variance_change = 0;
  double curvature_variance_change = 0;  ///< ΔVar(H) = |Var(H) − Var(H0)| / Var(H0)
  /// d_h: mean distance from the original's vertices to the result, of the original's bounding-box diagonal.
  double mean_distance = 0;
  double area_variance = 0;           ///< Var(A) / (Nv Ā²) of the result
  double original_area_variance = 0;  ///< of the original
  /// Mean angle between the normals of the original, area by area, and those of the nearest triangles of the
  /// result; radians.
  double normal_error = 0;
};

/// @param crease_angle vertices on borders and on edges that turn by more than this, radians, are left out of
/// curvatures: there H is that of the edge, in inverse proportion to the size of the triangles.
/// @throws InvalidInput when a mesh has no triangles or is no oriented manifold; Cancelled.
RemeshMeasures remesh_measures(const TriangleMesh& original, const TriangleMesh& result,
                               double crease_angle = radians(30.0), const Progress& progress = {});

}  // namespace batten
