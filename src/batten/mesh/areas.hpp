#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Areas of triangles, m values, in squared units of the positions.
Eigen::VectorXd face_areas(const Points& positions, const Triangles& triangles);

/// Their sum.
double surface_area(const Points& positions, const Triangles& triangles);

/// The volume enclosed by a closed mesh, positive when its faces are counter-clockwise seen from outside:
/// Σ det(a, b, c) / 6 with the origin in the middle of the bounding box (H (1.30), docs/errata.md#h-1).
/// Without meaning when the mesh is open.
double enclosed_volume(const Points& positions, const Triangles& triangles);

}  // namespace batten
