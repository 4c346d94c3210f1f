#pragma once
#include <Eigen/Core>

// Private to the room.
namespace batten::detail {

/// Twice the signed area of the triangle from the origin to a and b.
inline double cross_in_plane(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace batten::detail
