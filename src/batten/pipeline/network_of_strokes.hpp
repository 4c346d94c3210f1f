#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/network/diagnosis.hpp"

namespace batten {

/// Options of network_of_strokes(). Relative lengths are of the diameter of the strokes.
struct NetworkOfStrokesOptions {
  /// Strokes this near meet; above 0. Nothing: what gives the simplest surface.
  std::optional<Length> weld;
  /// Ends are extended to a stroke this near; 0 extends none.
  Length reach{0.03, Length::Kind::Relative};
  /// Distance of the samples on the cleaned curves; 0 keeps those of the file.
  Length step{0.015, Length::Kind::Relative};

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A stroke set as a network that can be filled. Lengths in the unit of the strokes.
struct NetworkOfStrokes {
  CurveNetwork network;              ///< sampled evenly, with estimated normals
  std::vector<NetworkCycle> cycles;  ///< its patches
  int n_handles = 0;                 ///< genus
  int n_strokes = 0;
  int n_dangling_ends = 0, n_near_misses = 0;
  int n_open_crossings = 0;  ///< crossings and T-junctions without a shared vertex
  int n_overdrawn = 0;       ///< pieces drawn twice
  int n_extended_ends = 0;
  int n_left_out = 0;         ///< pieces that are on no patch
  double weld_tolerance = 0;  ///< the one used
  double diameter = 0;        ///< of the strokes
  int n_doubtful_places = 0;
  std::vector<NetworkFinding> findings;  ///< what was found in the strokes
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Cleans strokes without normals or topology, samples them evenly, finds the patches and estimates normals.
/// @throws InvalidInput for options out of range, strokes without extent, and where no patch is left;
/// Cancelled.
NetworkOfStrokes network_of_strokes(const CurveNetwork& strokes, const NetworkOfStrokesOptions& options = {},
                                    const Progress& progress = {});

/// Whether a finding needs a person's eye: crossings and ends on a stroke are what every stroke set has, and
/// are welded without a word.
bool is_notable(const NetworkFinding& finding);

}  // namespace batten
