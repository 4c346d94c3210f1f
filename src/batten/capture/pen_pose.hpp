#pragma once
#include <optional>
#include <span>
#include <vector>

#include "batten/camera/blobs.hpp"

namespace batten {

/// A blob that is known to be the image of an LED.
struct LedImage {
  CameraSide camera = CameraSide::Left;
  int led = 0;
  Blob blob;
};

using PenInformation = Eigen::Matrix<double, 5, 5>;

/// A pose of a pen from one moment, with what it is worth.
struct PoseEstimate {
  PenPose pose;
  /// Of the tip (metres, first three) and of the direction along tangent_basis() (radians).
  PenInformation covariance = PenInformation::Zero();
  double chi_square = 0;  ///< Σ rᵀ Σ⁻¹ r over all blobs
  int n_blobs = 0;

  Eigen::Matrix3d tip_covariance() const { return covariance.topLeftCorner<3, 3>(); }
};

/// The normal matrix of a pose, Σ Jᵀ Σ⁻¹ J over the blobs: at the true pose its inverse is the Cramér–Rao
/// bound. LEDs behind a camera count nothing.
PenInformation pose_information(const StereoRig& rig, const Pen& pen, const PenPose& pose,
                                std::span<const LedImage> images);

/// Σ rᵀ Σ⁻¹ r of a pose; infinite where an LED lies behind a camera.
double pose_misfit(const StereoRig& rig, const Pen& pen, const PenPose& pose,
                   std::span<const LedImage> images);

/// Bundle adjustment of tip and direction (5 unknowns) over all blobs of either camera, by Levenberg's and
/// Marquardt's method from a start: LED i lies at p + (T + l_i) d. Blobs that one camera alone sees count,
/// too, and one camera with three LEDs is enough, with the covariance that this deserves.
/// @return nothing where fewer than five numbers were measured, where the blobs do not determine the pose, or
/// where no pose in front of the cameras was found. Costs some microseconds.
std::optional<PoseEstimate> fit_pose(const StereoRig& rig, const Pen& pen, std::span<const LedImage> images,
                                     const PenPose& start);

/// The pose of least squares through points of LEDs (H 4.11–4.13): the line through them and, along it, the
/// tip from the centroid. Weights are equal.
/// @param leds  which LED each of the points is, two different ones at least
/// @param points  as many
PenPose pose_of_points(const Pen& pen, std::span<const int> leds, std::span<const Eigen::Vector3d> points);

}  // namespace batten
