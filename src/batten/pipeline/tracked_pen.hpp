#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/capture/pen_strokes.hpp"
#include "batten/capture/pen_tracker.hpp"
#include "batten/capture/pen_triangulation.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/stage_times.hpp"

namespace batten {

enum class PenMethod {
  Bundle,       ///< bundle adjustment and one filter over the frames of both cameras
  Triangulate,  ///< the way of H 4.1: points, a line, a Gaussian over time
};

constexpr auto choices_of(PenMethod) {
  return choices<PenMethod>("tracking method",
                            {{PenMethod::Bundle, "bundle"}, {PenMethod::Triangulate, "triangulate"}});
}

/// Options of tracked_pen(). The defaults are those of `batten track`.
struct TrackedPenOptions {
  Pen pen;
  PenMethod method = PenMethod::Bundle;
  TrackOptions track;
  TriangulatedTrackOptions triangulated;
  PenStrokeOptions strokes;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A recording as a track of the pen and the strokes that it drew.
struct TrackedPen {
  PenTrack track;
  PenStrokes strokes;
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;
};

/// From blobs to strokes: track_pen() or track_pen_by_triangulation(), strokes_of_track().
/// @throws InvalidInput on bad options, a bad rig, and recordings without frames of both cameras.
TrackedPen tracked_pen(const BlobRecording& recording, const StereoRig& rig,
                       const TrackedPenOptions& options = {});

}  // namespace batten
