#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/network/curve_network.hpp"
#include "batten/network/diagnosis.hpp"
#include "batten/strokes/snapping.hpp"

namespace batten {

/// Joins curves that follow each other at vertices where nothing else meets, as long as both or neither are
/// tagged as boundary. Tagged nodes stay ends. A joined curve has the name of its first piece.
/// @throws InvalidInput as network_topology().
CurveNetwork joined_curves(const CurveNetwork& network);

/// Options of clean_strokes(), as fractions of the diameter.
struct StrokeCleaningOptions {
  /// Strokes this near to each other meet; strokes that run along each other this near are one.
  double weld_tolerance = 0.005;
  /// An end is extended to a stroke this near.
  double reach = 0.03;
  /// Pairs of curves between the same nodes that are both shorter than this bound no patch, nor do loops
  /// shorter than twice this; at least six weld tolerances count.
  double shortest_side = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Strokes made into a network, and what it took.
struct CleanedStrokes {
  CurveNetwork network;     ///< every end meets a node, every curve can have two patches; may be empty
  int n_strokes = 0;        ///< curves that came, joined where two of them follow each other
  int n_overdrawn = 0;      ///< pieces left out because another stroke runs there
  int n_extended_ends = 0;  ///< ends extended to the nearest stroke
  /// Pieces left out because they end in nothing or lead to a part by one curve only, and whole strokes that
  /// are too short beside the size of them all.
  int n_left_out = 0;
  WeldReport weld;  ///< of all rounds
  /// What was wrong with the strokes as they came, as diagnose_network() says it: dangling ends, near misses,
  /// overlaps, separate parts.
  std::vector<NetworkFinding> findings;
  std::vector<std::string> warnings;  ///< what was left out, in words
};

/// Makes a network of strokes as drawing programs write them: joins strokes that follow each other, leaves
/// out what is drawn twice, welds what nearly meets (welded()), extends ends to what is in reach, merges
/// nodes that lie together, and leaves out what no patch can have on its border. Normals are dropped.
/// @throws InvalidInput for options out of range, or as network_topology().
CleanedStrokes clean_strokes(const CurveNetwork& strokes, const StrokeCleaningOptions& options = {});

}  // namespace batten
