#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// A point of a surface that stands for a piece of it.
struct AreaSample {
  Eigen::Vector3d point, normal;  ///< normal: unit, of its triangle
  double area = 0;                ///< of the piece
  int triangle = -1;
};

/// Points spread over a surface by area: the centres of the pieces when every triangle is cut into k² equal
/// ones, the least k for which pieces are at most `largest`. Triangles without area get none.
std::vector<AreaSample> area_samples(const Points& positions, const Triangles& triangles, double largest);

}  // namespace batten
