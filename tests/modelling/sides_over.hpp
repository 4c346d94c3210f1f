#pragma once
#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/curves/polyline.hpp"

namespace batten::test {

/// The sides of a face: the images of a polygon's edges under a map, each of n straight pieces.
inline std::vector<SharedPolyline> sides_over(
    const std::function<Eigen::Vector3d(const Eigen::Vector2d&)>& map,
    const std::vector<Eigen::Vector2d>& corners, int n = 40) {
  std::vector<SharedPolyline> sides;
  for (size_t k = 0; k < corners.size(); ++k) {
    Points points(n + 1, 3);
    for (int i = 0; i <= n; ++i) {
      const double t = static_cast<double>(i) / n;
      points.row(i) = map((1 - t) * corners[k] + t * corners[(k + 1) % corners.size()]).transpose();
    }
    sides.push_back(std::make_shared<Polyline>(points));
  }
  return sides;
}

/// The map of the plane onto z = 0.
inline Eigen::Vector3d flat(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 0};
}

}  // namespace batten::test
