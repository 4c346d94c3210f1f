#pragma once
#include "batten/core/arrays.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// Unit normals of the corners of all triangles, 3m × 3 in the order of the triangles: smooth over a vertex
/// [thuermer1998] but for triangles whose normals differ from the corner's own by more than the angle.
/// Corners of a vertex with one set of such neighbours have equal normals, bit for bit. Time O(m) for
/// vertices of bounded valence.
/// @param crease_angle in radians, 0 … π.
Points corner_normals(const TriangleMesh& mesh, double crease_angle);

}  // namespace batten
