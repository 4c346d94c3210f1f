#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Principal curvatures and directions of every triangle. Positive on a sphere with outward normals.
struct FaceCurvatures {
  Eigen::VectorXd first, second;  ///< κ1, κ2 with |κ1| ≥ |κ2|, 1/length
  Points first_direction;         ///< m × 3 unit vectors in the plane of the triangle; zero without area
  Points second_direction;        ///< perpendicular to the first, in the plane too
};

/// From the turning of the normals at the corners (n × 3, unit) along the three sides: the symmetric 2 × 2
/// shape operator S of each triangle that fits S e = ΔN best [rusinkiewicz2004].
FaceCurvatures face_curvatures(const Points& positions, const Triangles& triangles,
                               const Points& vertex_normals);

}  // namespace batten
