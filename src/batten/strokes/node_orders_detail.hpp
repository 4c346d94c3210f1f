#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/strokes/link_graph_detail.hpp"

// The order of the curves around every node of a network without normals. Private to the room.
namespace batten::detail {

/// A choice that the search made by little.
struct DoubtfulOrder {
  int node = -1;
  bool turned_over = false;  ///< the doubt is which side is which, not the order around the node
  double margin = 0;         ///< cost that the next best choice has more
};

struct OrderSearchResult {
  std::vector<std::vector<int>> orders;  ///< per node: its link half-edges, counter-clockwise
  std::vector<DoubtfulOrder> doubtful;   ///< by increasing margin
};

/// The cheapest orders found; see estimate_cycles() for the costs.
OrderSearchResult search_node_orders(const CurveNetwork& network, const LinkGraph& graph,
                                     const Progress& progress);

/// Orbits of half-edges: the half-edge that follows each one in the walk around the region to its left.
std::vector<int> following_half_edges(const std::vector<std::vector<int>>& orders, std::size_t n_half_edges);

/// Turns `v` as the least rotation from unit vector a to unit vector b does.
Eigen::Vector3d carried(const Eigen::Vector3d& v, const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace batten::detail
