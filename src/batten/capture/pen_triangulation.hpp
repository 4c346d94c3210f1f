#pragma once
#include <optional>
#include <string>

#include "batten/camera/triangulation.hpp"
#include "batten/capture/pen_tracker.hpp"

namespace batten {

/// How a pen is tracked in the way of H 4.1.
struct TriangulatedTrackOptions {
  Triangulation triangulation = Triangulation::Midpoint;
  /// Standard deviation of the Gaussian over the tip's positions (H 4.1.3), seconds, 0 to 10; 0: none. It
  /// shrinks curves: by half of its square times the acceleration.
  double gaussian = 0.025;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The thesis's way, kept for comparison: every left frame with the newest right one, LEDs seen by both
/// triangulated, the line of least squares and the tip along it (4.11–4.13), a Gaussian over time. Frames in
/// which fewer than two LEDs are seen by both cameras are lost. The LEDs are found by identify(), which is
/// kinder than the thesis's comparison of distances. In the samples, `current` is the pose of the frame
/// alone, `pose` and `smoothed` are after the Gaussian; there is no covariance, and right frames have no
/// sample.
/// @throws InvalidInput on bad options, and as PenTracker().
PenTrack track_pen_by_triangulation(const BlobRecording& recording, const StereoRig& rig, const Pen& pen,
                                    const TriangulatedTrackOptions& options = {});

}  // namespace batten
