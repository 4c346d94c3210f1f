#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/rig.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// The lights of a wand, or of a pen, seen by both cameras at one time, in any order.
struct WandFrame {
  double time = 0;                           ///< seconds
  std::vector<Eigen::Vector2d> left, right;  ///< blobs, pixels
};

/// Options of calibrate_wand() and check_wand().
struct WandOptions {
  /// Places of the lights along the wand, metres, increasing from 0: at least 2. Those of the pen by default.
  std::vector<double> lights = {0, 0.07, 0.11, 0.16};
  /// Distance in pixels from which on the weight of a blob falls (Huber); at least 0.01.
  double huber = 1.0;
  /// Frames whose residual is beyond this multiple of the median are left out at the end; at least 2.
  double outliers = 4.0;
  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What a wand shows of a rig: no board is needed, and it can be waved at any time.
struct WandCheck {
  int frames = 0;           ///< with all lights in both images
  int unused = 0;           ///< others
  double epipolar = 0;      ///< mean epipolar_distance() of the lights, pixels
  double epipolar_rms = 0;  ///< pixels
  double length = 0;        ///< median distance of the outer lights, metres
  double length_std = 0;    ///< its robust standard deviation in one frame, metres
  double trend =
      0;  ///< change of the length over the recording by a straight line, metres: warmth, loose focus
};

/// Result of calibrate_wand().
struct WandCalibration {
  StereoRig rig;  ///< cameras as they were; rotation and translation new
  WandCheck before, after;
  int left_out = 0;  ///< frames of `after` that took no part in the last adjustment
  double rms = 0;    ///< distance of blobs to projections, pixels
  Eigen::Vector3d rotation_deviation = Eigen::Vector3d::Zero();  ///< radians, about axes of the right camera
  Eigen::Vector3d translation_deviation = Eigen::Vector3d::Zero();  ///< metres
};

/// The lights of the wand that most frames show in both images: two, at its ends, or the four of the pen; the
/// outer ones `length` metres apart.
/// @throws InvalidInput when neither is in a tenth of the frames.
std::vector<double> wand_lights(const std::vector<WandFrame>& frames, double length);

/// Measures a rig by the lights of a wand. Lights are matched by their order along the wand; of both senses
/// the one with the smaller epipolar error is taken, so it needs a rig that is right to some degrees.
/// @throws InvalidInput as problem() of rig and options; when no frame shows all lights in both images.
WandCheck check_wand(const StereoRig& rig, const std::vector<WandFrame>& frames,
                     const WandOptions& options = {});

/// Finds rotation and translation between the cameras anew from a wand that is waved through the volume: an
/// adjustment of both and of the place of the wand in every frame, whose lights are at known distances, which
/// give the scale. The cameras themselves stay. Cost: O(frames) per step, the places are eliminated.
/// @throws InvalidInput as check_wand(); with fewer than 20 frames, or where the wand stayed within a tenth
/// of its distance or a tenth of the image; Cancelled.
WandCalibration calibrate_wand(const StereoRig& rig, const std::vector<WandFrame>& frames,
                               const WandOptions& options = {}, const Progress& progress = {});

}  // namespace batten
