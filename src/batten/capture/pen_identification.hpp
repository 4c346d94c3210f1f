#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>

#include "batten/capture/pen_pose.hpp"

namespace batten {

/// For every LED of a pen which blob is its image; −1: none.
using LedBlobs = std::array<int, kPenLeds>;

/// How the LEDs are found among the blobs of two images.
struct IdentificationOptions {
  double nearest = 0.1;   ///< least depth of an LED, metres, above 0
  double farthest = 3.0;  ///< greatest one, above `nearest`
  /// Roughly the distance that the pen moves between the times of both images, metres, at least 0: added to
  /// what blobs may be off.
  double motion = 0;
  /// Standard deviation added to that of every blob, pixels, at least 0: what the rig is not known to.
  double rig_error = 0;
  /// The direction of the pen, where it is known to 60°: two LEDs alone do not tell it from its opposite.
  std::optional<Eigen::Vector3d> direction;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

enum class IdentificationState {
  Found,
  Ambiguous,  ///< two poses more than 20 mm apart fit nearly as well
  None,       ///< no pose fits two LEDs in both cameras
};

/// Which blobs are which LEDs, and the pose that follows.
struct Identification {
  IdentificationState state = IdentificationState::None;
  PoseEstimate estimate;  ///< of the best pose, but with None
  LedBlobs left = {-1, -1, -1, -1}, right = {-1, -1, -1, -1};
  double score = 0;    ///< 9 for every blob that is explained, less χ²
  std::string reason;  ///< where not Found, in words
};

/// Exhaustive search: all pairs of blobs that triangulate, all pairs of such points whose distance is that of
/// two LEDs, the poses that follow; ranked by the blobs that they explain in each camera, the best eight
/// adjusted (fit_pose()) and scored by 9 · count − χ². Under 2 ms for eight blobs in each camera; the number
/// of poses grows with the fourth power of the number of blobs, and of more than 16 in an image those with
/// the least covariance are taken.
Identification identify(const StereoRig& rig, const Pen& pen, std::span<const Blob> left,
                        std::span<const Blob> right, const IdentificationOptions& options = {});

/// The images of LEDs by an assignment.
void append_images(CameraSide camera, std::span<const Blob> blobs, const LedBlobs& assigned,
                   std::vector<LedImage>& images);

/// For a pose that is given: blobs within `gate` standard deviations of the LEDs' images, the nearest taken
/// first. @param spread  standard deviation added to every blob, pixels
LedBlobs nearest_blobs(const StereoRig& rig, CameraSide camera, const Pen& pen, const PenPose& pose,
                       std::span<const Blob> blobs, double gate, double spread);

}  // namespace batten
