#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "batten/camera/blobs.hpp"
#include "batten/capture/pen_tracker.hpp"
#include "batten/core/arrays.hpp"

namespace batten {

/// How strokes are cut out of a track.
struct PenStrokeOptions {
  /// Least distance between points, metres, at least 0 (the thinning of H 4.1.3).
  double spacing = 1e-3;
  /// A pen that is lost for longer ends its stroke, seconds, at least 0.
  double gap = 0.2;
  /// Strokes shorter than this are slips of the button, metres, at least 0.
  double shortest = 2e-3;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What the tip drew while the button was down.
struct PenStroke {
  Points points;          ///< n × 3, left camera coordinates, metres
  Eigen::VectorXd sigma;  ///< n, standard deviation of each point (square root of the mean variance), metres
  double from = 0, to = 0;  ///< seconds
};

/// The strokes of a track, and what was left out of them.
struct PenStrokes {
  std::vector<PenStroke> strokes;
  long slips = 0;   ///< too short
  long broken = 0;  ///< strokes that were cut in two because the pen was lost
};

/// Strokes from the smoothed poses of a track: cut where the button "draw" goes up and where the pen is lost
/// for long. Without any event of that button all of the track is drawn.
/// @throws InvalidInput on bad options.
PenStrokes strokes_of_track(std::span<const PenSample> samples, std::span<const ButtonEvent> buttons,
                            const PenStrokeOptions& options = {});

}  // namespace batten
