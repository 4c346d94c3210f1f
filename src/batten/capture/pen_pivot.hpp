#pragma once
#include <array>
#include <optional>
#include <string>

#include "batten/camera/blobs.hpp"

namespace batten {

/// How a pen is calibrated by turning it about its tip.
struct PivotOptions {
  int least_frames = 100;    ///< with three LEDs or more, at least 10
  double least_tilt = 0.35;  ///< radians, between the two directions farthest apart, 0.05 to 3
  double outliers = 4;       ///< frames whose misfit is this many times the median are left out, at least 2

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A pen as it is, with what it is worth.
struct PivotCalibration {
  Pen pen;
  double tip_offset_sigma = 0;               ///< metres
  std::array<double, kPenLeds> led_sigma{};  ///< metres; 0 for the first
  Eigen::Vector3d tip;                       ///< where the dimple is, left camera coordinates, metres
  Eigen::Vector3d tip_sigma;                 ///< metres
  double rms = 0;                            ///< of blobs from their LEDs' images, pixels
  double residual = 0;  ///< of the tip: how far poses of single frames miss the dimple, rms, metres
  double tilt = 0;      ///< radians, between the two directions farthest apart
  int frames = 0;       ///< used
  int left_out = 0;     ///< as outliers
};

/// Pivot calibration: the tip rests in a dimple while the pen turns about it. One bundle adjustment of tip, T
/// and l_2 … l_4 over all frames, each with a direction of its own (eliminated frame by frame), over the
/// blobs of frames in which a camera sees three LEDs; LED i at p + (T + l_i) d_k. Lengths come from the base
/// of the rig. Standard deviations are multiplied by what the residuals exceed the blobs' own. Cost linear in
/// the frames.
/// @param nominal  LEDs to some millimetres, for their identities; T to some centimetres
/// @throws InvalidInput in words: too few frames, a pen that was hardly tilted, a bad rig, pen or option, or
/// a tip that was not at rest.
PivotCalibration calibrate_pivot(const BlobRecording& recording, const StereoRig& rig, const Pen& nominal,
                                 const PivotOptions& options = {});

}  // namespace batten
