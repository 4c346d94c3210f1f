#pragma once
#include <optional>
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

  /// The first problem found, naming handle and vertex, or nothing: a vertex out of range or named twice,
  /// targets that are not one per vertex, an axis that is not of unit length, numbers that are not finite.
  /// @param n_vertices of the mesh.
  std::optional<std::string> problem(Eigen::Index n_vertices) const;
};

}  // namespace batten
