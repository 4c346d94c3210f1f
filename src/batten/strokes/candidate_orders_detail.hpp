#pragma once
#include <vector>

#include <Eigen/Core>

// The orders in which the curves of one node may lie around it. Private to the room.
namespace batten::detail {

/// One order of the half-edges of a node, by their places in the node's list.
struct NodeOrder {
  std::vector<int> sequence;     ///< counter-clockwise, beginning with place 0
  std::vector<int> left, right;  ///< per place: the next and the previous place
  double cost = 0;               ///< more than the cheapest order of the node
  int mirrored = -1;             ///< number of the same order seen from the other side
};

/// The orders worth a look, by increasing sequence, each with its mirror image: all of them up to seven
/// half-edges, those seen along likely axes beyond. An order costs 1 / π for every radian that its sectors
/// turn; the outside, between two borders, turns as far as it likes.
/// @param tangents unit directions in which the half-edges leave the node; none gives no order.
/// @param borders the places of half-edges on the border; where there are two, nothing lies between them.
std::vector<NodeOrder> candidate_orders(const std::vector<Eigen::Vector3d>& tangents,
                                        const std::vector<int>& borders);

}  // namespace batten::detail
