#pragma once
#include "batten/capture/pen_accuracy.hpp"
#include "batten/capture/pen_tracker.hpp"
#include "batten/core/units.hpp"
#include "batten/simulation/pen.hpp"

namespace batten::test {

struct Judged {
  SimulatedPen simulated;
  PenTrack track;
  PenAccuracy accuracy;
};

/// Four seconds of a pen, tracked and held against their truth.
inline Judged judge(SimulatePenOptions options, std::uint64_t seed, PenPath path = PenPath::Circle,
                    const TrackOptions& track = {}) {
  options.motion.seed = seed;
  options.motion.duration = 4;
  Judged result;
  result.simulated = simulate_pen(strokes_of(path), options);
  result.track = track_pen(result.simulated.recording, result.simulated.nominal, options.pen, track);
  result.accuracy =
      pen_accuracy(result.simulated.recording, result.track, options.pen, result.simulated.truth);
  return result;
}

}  // namespace batten::test
