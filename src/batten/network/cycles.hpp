#pragma once
#include <vector>

#include "batten/network/curve_network.hpp"

// From an order of the curves around every node to patches. Private to the room.
namespace batten::detail {

/// What is known about a network beyond its curves.
struct NodeOrders {
  /// Per node of network_topology() the half-edges that leave it, counter-clockwise seen from outside;
  /// half-edge 2s walks segment s forwards, half-edge 2s + 1 backwards.
  std::vector<std::vector<int>> half_edges;
  /// Per half-edge: the region to its left is no patch but the outside of the surface.
  std::vector<char> outside;
};

/// find_cycles() with the orders given instead of taken from the tangent planes. Normals are needed all the
/// same: they tell which loops of separate parts face each other. Borders are those that are tagged and those
/// of regions given as outside; what looks like another one is filled.
CycleReport collect_cycles(const CurveNetwork& network, const NodeOrders& orders);

}  // namespace batten::detail
