#pragma once
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/camera/camera.hpp"

namespace batten {

/// Two cameras on one stand. X_right = rotation · X_left + translation takes left camera coordinates, which
/// are those of the rig, to right ones. Lengths in metres.
struct StereoRig {
  Camera left;
  Camera right;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  /// Of the right camera, in left coordinates: C = −Rᵀ T.
  Eigen::Vector3d right_centre() const { return -(rotation.transpose() * translation); }
  /// Distance of the camera centres.
  double baseline() const { return translation.norm(); }
};

/// What is wrong with a rig, with field, value and range; empty when nothing is: cameras, a rotation that is
/// none, cameras at one place.
std::string problem(const StereoRig& rig);

/// E = T× R on normalised coordinates: x_rightᵀ E x_left = 0 for two images of one point.
Eigen::Matrix3d essential_matrix(const StereoRig& rig);

/// How far two pixels are from being images of one point: mean of the distances of each point to the line
/// that the other one draws in its image, after undistortion and multiplied by the focal length (√(fx fy)),
/// pixels. Nothing where a pixel belongs to no ray (undistort()).
std::optional<double> epipolar_distance(const StereoRig& rig, const Eigen::Vector2d& left_pixel,
                                        const Eigen::Vector2d& right_pixel);

}  // namespace batten
