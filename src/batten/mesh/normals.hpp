#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Unit normals of triangles, m × 3, by the right-hand rule; zero rows for triangles without area.
Points face_normals(const Points& positions, const Triangles& triangles);

/// Unit normals of vertices, n × 3: the normals of the triangles around each vertex weighted by their angles
/// there, which does not depend on how flat pieces are cut into triangles [thuermer1998]. Zero
/// rows where no triangle has area.
Points vertex_normals(const Points& positions, const Triangles& triangles);

/// Mean angle between the normals of corresponding triangles of two meshes of one connectivity, in [0, π]
/// radians. Triangles without area in either have no normal and do not count; 0 where none does.
/// @param a, b positions, n × 3 each.
double mean_normal_angle(const Points& a, const Points& b, const Triangles& triangles);

}  // namespace batten
