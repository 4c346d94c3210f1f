#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/strokes/estimated_cycles.hpp"
#include "batten/strokes/stroke_cleaning.hpp"

namespace batten {

/// Options of stroke_network(), as fractions of the diameter.
struct StrokeNetworkOptions {
  /// As in StrokeCleaningOptions; 0 tries several, from 0.5 to 1.5 % and then below, and takes the first with
  /// the simplest surface: the fewest parts, handles, curves with one patch on both sides, pieces left out
  /// and doubtful places for each patch.
  double weld_tolerance = 0;
  double reach = 0.03;  ///< as in StrokeCleaningOptions
  double step =
      0.015;  ///< distance of the samples on the curves of the network; 0 keeps those of the strokes

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Strokes made ready for surfacing.
struct StrokeNetwork {
  CurveNetwork network;       ///< sampled evenly, with estimated normals
  EstimatedCycles estimate;   ///< its patches
  CleanedStrokes strokes;     ///< what became of the strokes; its network is not sampled
  double weld_tolerance = 0;  ///< the one used, a fraction of the diameter
  double diameter = 0;        ///< of the strokes
  /// What was left out, what could be read otherwise and where the surface is open, in words.
  std::vector<std::string> warnings;
  StageTimes times;
};

/// From strokes without normals to a network with patches and normals: clean_strokes(), resampled(),
/// estimate_cycles().
/// @throws InvalidInput for options out of range, strokes without extent, as those three, or where no cycle
/// is left; Cancelled.
StrokeNetwork stroke_network(const CurveNetwork& strokes, const StrokeNetworkOptions& options = {},
                             const Progress& progress = {});

/// Whether a finding needs a person's eye: crossings and ends on a stroke are what every stroke set has, and
/// are welded without a word.
bool is_notable(const NetworkFinding& finding);

}  // namespace batten
