#pragma once
#include <string>
#include <vector>

#include "batten/network/curve_network.hpp"

namespace batten {

/// A network cut open along its sharp curves, for methods that know one normal per vertex.
struct SharpSplit {
  /// The given vertices with their numbers, then copies: where sharp curves divide the surface around a
  /// vertex, every part has its own, with its own normal. Curves are pieces from node to node; sharp ones
  /// appear once for each side.
  CurveNetwork network;
  std::vector<NetworkCycle> cycles;  ///< as given, over vertices of `network`; without segments
  std::vector<int> place;            ///< per vertex of `network`: the given vertex at the same place
};

/// Cuts a network open along the curves that are `sharp`. The normal of a side at a sample of a sharp curve
/// is the one that the curve carries; else at nodes that of the curves that arrive on that side, carried on
/// to the node, or square to the plane of two sharp ones; and between nodes it turns about the curve by an
/// angle that is interpolated (cubic Hermite over arc length, against the normals given along the curve).
/// Where nothing arrives on a side it is that of the plane of the patch's outline, or of the cone from the
/// curve to its middle. Sharp curves that end inside the surface fade out there. On the border a curve has
/// one side: `sharp` means nothing. Linear in the samples, up to sorting.
/// @param network with normals: along sharp curves they should lie between those of the two sides.
/// @param cycles its patches, as find_cycles() gives them. @throws InvalidInput as network_topology().
SharpSplit split_at_sharp_curves(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles);

/// A curve that the normals around it show to be sharp.
struct SharpFinding {
  int curve = -1;
  double angle = 0;  ///< the least angle between the sides at its nodes, radians
  std::string sentence;
};

/// The curves that are not tagged, although at two nodes or more, and at all nodes with curves on both sides,
/// the normals of those curves, carried on to the node, differ by more than 20° from one side to the other
/// and by more than three times what they turn between their last two samples.
/// @param cycles the patches of the network. @throws InvalidInput as network_topology().
std::vector<SharpFinding> find_sharp_curves(const CurveNetwork& network,
                                            const std::vector<NetworkCycle>& cycles);

}  // namespace batten
