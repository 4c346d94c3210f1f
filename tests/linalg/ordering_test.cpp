#include "batten/linalg/ordering.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

AdjacencyGraph grid(int side) {
  Pairs joined;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      if (i + 1 < side) joined.emplace_back(side * i + j, side * (i + 1) + j);
      if (j + 1 < side) joined.emplace_back(side * i + j, side * i + j + 1);
    }
  return {side * side, joined};
}

/// Curves that cross as the threads of a cloth do, as the joint estimate of a scan sees them: every vertex is
/// joined to the next three of its curve, two meet at a crossing, and each segment has a vertex of its own
/// that is joined to all of it.
AdjacencyGraph cloth(int lines, int steps) {
  Pairs joined;
  const int n = (lines - 1) * steps + 1, segments = 2 * lines * n;
  const auto vertex = [&](int direction, int line, int k) { return (direction * lines + line) * n + k; };
  int next = segments;
  for (const int direction : {0, 1})
    for (int line = 0; line < lines; ++line) {
      for (int k = 0; k < n; ++k)
        for (int d = 1; d <= 3 && k + d < n; ++d)
          joined.emplace_back(vertex(direction, line, k + d), vertex(direction, line, k));
      for (int s = 0; s + 1 < lines; ++s, ++next)
        for (int k = 0; k <= steps; ++k) joined.emplace_back(next, vertex(direction, line, s * steps + k));
    }
  for (int i = 0; i < lines; ++i)
    for (int j = 0; j < lines; ++j) joined.emplace_back(vertex(1, j, i * steps), vertex(0, i, j * steps));
  return {next, joined};
}

AdjacencyGraph random_graph(int n, int n_edges, std::uint64_t seed) {
  Random random(seed);
  std::set<std::pair<int, int>> joined;
  for (int i = 0; i < n_edges; ++i) {
    const auto a = static_cast<int>(random.below(n)), b = static_cast<int>(random.below(n));
    if (a != b) joined.emplace(std::max(a, b), std::min(a, b));
  }
  return {n, Pairs(joined.begin(), joined.end())};
}

void expect_permutation(std::vector<int> order, int n) {
  std::sort(order.begin(), order.end());
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(order, all);
}

/// Elimination by its definition: the neighbours of a vertex that goes become neighbours of each other.
struct Played {
  Played(const AdjacencyGraph& graph, const std::vector<int>& order) {
    const int n = graph.size();
    std::vector<std::set<int>> after(n);
    std::vector<int> position(n);
    for (int j = 0; j < n; ++j) position[order[j]] = j;
    for (int v = 0; v < n; ++v)
      for (int e = graph.first[v]; e < graph.first[v + 1]; ++e)
        if (position[graph.list[e]] > position[v]) after[position[v]].insert(position[graph.list[e]]);
    for (int j = 0; j < n; ++j) {
      const double column = 1.0 + static_cast<double>(after[j].size());
      work += 0.5 * column * column;
      parent.push_back(after[j].empty() ? -1 : *after[j].begin());
      if (parent[j] < 0) continue;
      after[parent[j]].insert(std::next(after[j].begin()), after[j].end());
    }
  }
  double work = 0;
  std::vector<int> parent;
};

TEST(Ordering, CountsWorkAndParentsAsEliminationItself) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const AdjacencyGraph graph = random_graph(80, 30 + 60 * static_cast<int>(seed), seed);
    for (const std::vector<int>& order : {minimum_degree(graph), nested_dissection(graph)}) {
      const Played played(graph, order);
      EXPECT_EQ(elimination_tree(graph, order), played.parent);
      EXPECT_DOUBLE_EQ(elimination_work(graph, order), played.work);
    }
  }
}

TEST(Ordering, OrdersEveryUnknownOnce) {
  expect_permutation(fill_reducing_order({}), 0);
  expect_permutation(nested_dissection({1, {}}), 1);
  expect_permutation(nested_dissection({700, {}}), 700);  // no edges: parts without anything between them
  expect_permutation(nested_dissection(grid(40)), 1600);
  expect_permutation(nested_dissection(random_graph(900, 1000, 5)), 900);  // many components
  Pairs star, all;
  for (int i = 1; i < 400; ++i) star.emplace_back(i, 0);
  expect_permutation(nested_dissection({400, star}), 400);
  for (int i = 0; i < 300; ++i)
    for (int j = 0; j < i; ++j) all.emplace_back(i, j);
  expect_permutation(nested_dissection({300, all}), 300);
}

// Nested dissection of a grid of n × n takes less than 10 n³ multiplications [george1973].
TEST(Ordering, DissectionKeepsTheWorkOfGridsAtTheirOrder) {
  for (const int side : {40, 80, 160}) {
    const AdjacencyGraph graph = grid(side);
    EXPECT_LT(elimination_work(graph, nested_dissection(graph)), 10.0 * side * side * side) << side;
  }
}

TEST(Ordering, ChoosesTheOrderOfLessWork) {
  const AdjacencyGraph sheet = cloth(16, 10);
  const double work = elimination_work(sheet, fill_reducing_order(sheet));
  EXPECT_LT(work, 0.6 * elimination_work(sheet, minimum_degree(sheet)));
  EXPECT_EQ(work, elimination_work(sheet, nested_dissection(sheet)));
  // A chain needs no dissection, and an expander has no small parts: it makes things worse.
  Pairs joined;
  for (int i = 0; i + 1 < 5000; ++i) joined.emplace_back(i + 1, i);
  for (const AdjacencyGraph& graph : {AdjacencyGraph(5000, joined), random_graph(600, 3000, 9)}) {
    EXPECT_EQ(fill_reducing_order(graph), minimum_degree(graph));
    EXPECT_LT(elimination_work(graph, minimum_degree(graph)),
              elimination_work(graph, nested_dissection(graph)));
  }
}

TEST(Ordering, CanBeCancelled) {
  int reports = 0;
  const Progress stop([&](std::string_view, double) { return ++reports < 5; });
  EXPECT_THROW(fill_reducing_order(cloth(16, 10), stop), Cancelled);
  EXPECT_EQ(reports, 5);
}

}  // namespace
}  // namespace batten
