#pragma once
#include <span>
#include <vector>

#include "batten/capture/pen_tracker.hpp"

namespace batten {

/// Errors of a pen's tip and direction over some frames.
struct PenErrors {
  long frames = 0;
  double mean = 0, rms = 0, p95 = 0;  ///< of the tip, metres; p95: 95 of 100 are smaller
  double below_2mm = 0;               ///< share of frames
  double direction_p95 = 0;           ///< radians
};

/// The errors of frames in which the tip was this far from the middle between the cameras.
struct PenErrorBand {
  double from = 0, to = 0;  ///< metres
  PenErrors lagged;
};

/// A track held against the truth.
struct PenAccuracy {
  PenErrors current, lagged, smoothed;  ///< without lag, with it, from all frames: those that were answered
  std::vector<PenErrorBand> bands;      ///< 0.3 to 0.6, to 1, to 1.5 m, where there are any
  long wrong_identities = 0;            ///< frames with a blob taken for an LED that is elsewhere
  /// Frames in which each camera showed three LEDs or more, and of those the ones that were answered.
  long answerable = 0, answered = 0;
  /// Poses of fit_pose() from left frames alone, the right camera's blobs interpolated to their times, and
  /// the Cramér–Rao bound of the same blobs: root mean squares of the tip's error, metres.
  long single_frames = 0;
  double single_rms = 0, bound_rms = 0;
  double mean_chi_square =
      0;  ///< of the answered tips' errors by their covariances, over three: 1 when right
};

/// @param track  of the recording; samples of left frames alone are enough
/// @param truth  in order of time, at least two poses; between them it is interpolated
/// @throws InvalidInput when the truth has fewer than two poses or does not reach over the recording.
PenAccuracy pen_accuracy(const BlobRecording& recording, const PenTrack& track, const Pen& pen,
                         std::span<const TimedPose> truth);

}  // namespace batten
