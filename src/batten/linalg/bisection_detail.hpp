#pragma once
#include <numeric>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/random.hpp"

// Halves of graphs, for nested dissection. Private to the room.
namespace batten::detail {

/// A graph whose vertices and edges stand for several of a finer one.
struct WeightedGraph {
  std::vector<int> first{0}, list, edge_weight, weight;
  int size() const { return static_cast<int>(weight.size()); }
  int total() const { return std::accumulate(weight.begin(), weight.end(), 0); }
};

/// Halves of a graph with few edges between them, by multilevel bisection [karypis1998]. Neither half weighs
/// more than 0.55 of the whole, or half of it and the heaviest vertex.
/// @return per vertex its half, 0 or 1. @throws Cancelled.
std::vector<char> bisect(const WeightedGraph& graph, Random& random, const Progress& progress = {});

/// The fewest vertices that touch all edges between the halves (König's theorem): those of half 0 that no
/// alternating path from a free vertex of it reaches, and those of half 1 that one reaches.
class VertexCover {
 public:
  /// @param graph, side must outlive this.
  VertexCover(const WeightedGraph& graph, const std::vector<char>& side);
  bool contains(int v) const { return partner_[v] >= 0 && (side_[v] == 0 ? seen_[v] == 0 : seen_[v] == 1); }

 private:
  /// Whether v or one behind it finds a partner; breadth would not shorten it: cuts are small.
  bool augment(int v, int turn);

  const WeightedGraph& graph_;
  const std::vector<char>& side_;
  std::vector<int> partner_, seen_;
};

}  // namespace batten::detail
