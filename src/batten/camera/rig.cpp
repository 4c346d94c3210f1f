#include "batten/camera/rig.hpp"

#include <cmath>

#include <Eigen/LU>

#include "batten/core/text.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

std::string problem(const StereoRig& rig) {
  if (const std::string found = problem(rig.left); !found.empty()) return "left camera: " + found;
  if (const std::string found = problem(rig.right); !found.empty()) return "right camera: " + found;
  const double off = (rig.rotation * rig.rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(off < 1e-6) || rig.rotation.determinant() < 0)
    return concat("rotation is no rotation: R R' is off the identity by ", off);
  if (!rig.translation.allFinite() || !(rig.baseline() > 0))
    return "translation must be finite and not zero: both cameras stand at one place";
  return {};
}

Eigen::Matrix3d essential_matrix(const StereoRig& rig) {
  return hat(rig.translation) * rig.rotation;
}

std::optional<double> epipolar_distance(const StereoRig& rig, const Eigen::Vector2d& left_pixel,
                                        const Eigen::Vector2d& right_pixel) {
  const std::optional<Eigen::Vector2d> left = undistort(rig.left, left_pixel);
  const std::optional<Eigen::Vector2d> right = undistort(rig.right, right_pixel);
  if (!left || !right) return {};
  const Eigen::Matrix3d E = essential_matrix(rig);
  const Eigen::Vector3d in_right = E * left->homogeneous();
  const Eigen::Vector3d in_left = E.transpose() * right->homogeneous();
  const double residual = std::abs(right->homogeneous().dot(in_right));
  const auto pixels = [&](const Eigen::Vector3d& line, const Camera& camera) {
    return residual / line.head<2>().norm() * std::sqrt(camera.fx * camera.fy);
  };
  return (pixels(in_left, rig.left) + pixels(in_right, rig.right)) / 2;
}

}  // namespace batten
