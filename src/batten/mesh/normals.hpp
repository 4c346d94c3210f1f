#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Unit normals of triangles, m × 3, by the right-hand rule; zero rows for triangles without area.
Points face_normals(const Points& positions, const Triangles& triangles);

/// Unit normals of vertices, n × 3: the normals of the triangles around each vertex weighted by their angles
/// there, which does not depend on how flat pieces are cut into triangles (Thürmer and Wüthrich 1998). Zero
/// rows where no triangle has area.
Points vertex_normals(const Points& positions, const Triangles& triangles);

}  // namespace batten
