#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Vertices of a mesh that move together: rotated about a point, then translated; or each to a target.
struct HandleMotion {
  std::vector<int> vertices;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit
  double angle = 0;                                 ///< radians, right-handed about the axis
  Eigen::Vector3d about = Eigen::Vector3d::Zero();
  Points targets;  ///< one row per vertex, or 0 × 3: then the motion above holds
};

/// What a deformation is given: vertices that stay and vertices that move. No vertex is in two of them.
struct Handles {
  std::vector<int> fixed;
  std::vector<HandleMotion> moved;

  /// Fixed vertices, then those of the handles in order.
  std::vector<int> vertices() const;
  /// Where vertices() are after a share of the motion: angles, translations and straight ways to targets are
  /// done to this fraction. 1 is the whole.
  Points targets(const Points& positions, double share = 1) const;
  /// The largest angle of a handle, radians.
  double largest_angle() const;
};

/// Reads handles: {"fixed": SELECT, "handles": [{"select": SELECT, "translate": [x,y,z], "rotate_deg":
/// [ax,ay,az,angle], "about": [x,y,z]} or {"select": SELECT, "targets": [[x,y,z], …]}]}, with SELECT one of
/// {"vertices": […]}, {"box": [[x,y,z],[x,y,z]]} and {"sphere": [x,y,z,r]} (borders of both belong to them).
/// "fixed" may be left out, and "about" (then the origin).
/// @throws FileError naming the member: unknown or wrong, a selection without vertices, a vertex selected
/// twice.
Handles read_handles(const std::string& path, const Points& positions);

}  // namespace batten
