#pragma once
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {

/// Patches of a network whose normals are not known, and normals that go with them.
struct EstimatedCycles {
  std::vector<NetworkCycle> cycles;  ///< as find_cycles() gives them
  /// n × 3 unit normals: outward where the surface is closed, else on a side of the estimate's choice, one
  /// for each connected part. Vertices that no curve uses have (0, 0, 1).
  Points normals;
  std::vector<int> open_curves;  ///< curves not tagged as boundary with the outside on one side, increasing
  int n_handles = 0;    ///< genus of the surface with its openings closed, summed over the connected parts
  int n_one_sided = 0;  ///< links between branching nodes with the same patch on both sides
  std::vector<std::string> warnings;  ///< places that could be read otherwise, in words
};

/// Finds the patches of a network from its curves alone (after [zhuang2013]). Every node gets an order of the
/// curves around it. An order costs what its sectors turn in all beyond the least possible; two nodes with a
/// curve between them cost the angles between the patches at its one end, carried along the curve by a
/// rotation-minimising frame, and those at its other end. The orders of least cost are sought from the surest
/// node outwards, then by changing single nodes and by turning over groups of nodes that the curves between
/// them leave free; orders that make more patches (a simpler surface) are preferred slightly. Surfaces are
/// orientable and every curve has two patches, or one and the outside.
///
/// Normals come from the patches: seen from a point of its border, a patch looks along the mean normal of
/// the cone to its whole outline; both sides of a curve are averaged. At nodes whose curves lie in one plane
/// that plane counts. Along curves normals turn as little and as evenly as these allow.
///
/// Regions that fold back onto their neighbours are outside, as are those that tagged borders enclose.
/// @throws InvalidInput as find_cycles(), but for what it says of normals; Cancelled.
EstimatedCycles estimate_cycles(const CurveNetwork& network, const Progress& progress = {});

}  // namespace batten
