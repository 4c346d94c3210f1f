#pragma once
#include <utility>
#include <vector>

#include "batten/core/progress.hpp"

namespace batten {

/// Which unknowns of a sparse symmetric matrix meet: per vertex its neighbours, without itself.
struct AdjacencyGraph {
  AdjacencyGraph() : first(1, 0) {}
  /// @param n vertices. @param joined pairs below n, each named once; pairs of one vertex are left out.
  AdjacencyGraph(int n, const std::vector<std::pair<int, int>>& joined);

  int size() const { return static_cast<int>(first.size()) - 1; }

  std::vector<int> first;  ///< n + 1, where the neighbours of a vertex begin in `list`
  std::vector<int> list;
};

/// Parents in the elimination tree of a matrix, −1 for roots. O(edges), nearly.
/// @param order the unknowns in the order of elimination; the tree is over places in it.
std::vector<int> elimination_tree(const AdjacencyGraph& graph, const std::vector<int>& order);

/// Multiplications of a factorisation in this order: half the sum over the columns of the factor of the
/// square of their entries. Time as the entries of the factor, memory as the unknowns.
double elimination_work(const AdjacencyGraph& graph, const std::vector<int>& order);

/// Approximate minimum degree [amestoy1996]. @return the order of elimination.
std::vector<int> minimum_degree(const AdjacencyGraph& graph);

/// Nested dissection [george1973]: a few unknowns that part the others into halves come last, and so on in
/// each half; parts of some hundred unknowns by minimum degree. Keeps the work of a plane grid of n
/// unknowns at n^1.5. Halves are found by multilevel bisection [karypis1998], the unknowns between them as
/// the least cover of the edges that are cut. Depends on the graph alone. Takes some twenty times as long as
/// minimum degree. @return the order of elimination. @throws Cancelled.
std::vector<int> nested_dissection(const AdjacencyGraph& graph, const Progress& progress = {});

/// Minimum degree, or nested dissection where that is tried and found to be less work: it is tried where
/// minimum degree leaves many multiplications per unknown, as networks that are sheets do. @throws Cancelled.
std::vector<int> fill_reducing_order(const AdjacencyGraph& graph, const Progress& progress = {});

}  // namespace batten
