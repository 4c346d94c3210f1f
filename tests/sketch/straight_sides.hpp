#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten::test {

/// The straight sides of a polygon, each sampled at so many segments.
inline std::vector<Points> straight_sides(const std::vector<Eigen::Vector3d>& corners, int segments) {
  std::vector<Points> sides;
  for (size_t k = 0; k < corners.size(); ++k) {
    Points side(segments + 1, 3);
    for (int i = 0; i <= segments; ++i) {
      const double t = static_cast<double>(i) / segments;
      side.row(i) = (1 - t) * corners[k] + t * corners[(k + 1) % corners.size()];
    }
    sides.push_back(side);
  }
  return sides;
}

}  // namespace batten::test
