#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/network/curve_network.hpp"

// A network without the nodes where a curve only goes on. Private to the room.
namespace batten::detail {

/// A chain of segments through nodes where only two of them meet.
struct NetworkLink {
  std::vector<int> vertices;    ///< from node to node, both included
  std::vector<int> half_edges;  ///< of the segments, in the order of the walk; as in NodeOrders
  int from = -1, to = -1;       ///< node numbers
  bool border = false;          ///< all of it is tagged as boundary
  double length = 0;
};

/// A network as links between its branching nodes (and one node on every closed curve that meets nothing).
struct LinkGraph {
  NetworkTopology topology;
  std::vector<NetworkLink> links;
  /// Per node of the topology: the link half-edges that leave it (2l forwards along link l, 2l + 1
  /// backwards), in increasing order; none at the nodes that links pass through.
  std::vector<std::vector<int>> half_edges;
};

/// @throws InvalidInput as network_topology(), for positions that are not finite and edges without length.
LinkGraph link_graph(const CurveNetwork& network);

/// The unit direction in which a link half-edge leaves its node, from samples near enough to show it and far
/// enough not to see what welding bent.
/// @param size of the network.
Eigen::Vector3d link_direction(const CurveNetwork& network, const LinkGraph& graph, int half_edge,
                               double size);

/// Twice the greatest distance of a vertex from the mean of all; unlike a box, it turns with the network.
double network_size(const CurveNetwork& network, const LinkGraph& graph);

}  // namespace batten::detail
