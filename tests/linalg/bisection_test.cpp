#include <algorithm>
#include <array>
#include <numeric>

#include <gtest/gtest.h>

#include "batten/linalg/bisection_detail.hpp"

namespace batten {
namespace {

using detail::bisect;
using detail::VertexCover;
using detail::WeightedGraph;

/// A grid of columns × rows vertices, joined to the next in either direction; all weights 1.
WeightedGraph grid(int columns, int rows) {
  WeightedGraph graph;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      if (r > 0) graph.list.push_back((r - 1) * columns + c);
      if (c > 0) graph.list.push_back(r * columns + c - 1);
      if (c + 1 < columns) graph.list.push_back(r * columns + c + 1);
      if (r + 1 < rows) graph.list.push_back((r + 1) * columns + c);
      graph.first.push_back(static_cast<int>(graph.list.size()));
    }
  graph.edge_weight.assign(graph.list.size(), 1);
  graph.weight.assign(static_cast<size_t>(columns * rows), 1);
  return graph;
}

int cut_of(const WeightedGraph& graph, const std::vector<char>& side) {
  int cut = 0;
  for (int v = 0; v < graph.size(); ++v)
    for (int e = graph.first[v]; e < graph.first[v + 1]; ++e)
      if (side[v] < side[graph.list[e]]) cut += graph.edge_weight[e];
  return cut;
}

// A long strip can be cut across by as many edges as it has rows, and not by fewer.
TEST(Bisect, CutsAStripAcross) {
  const WeightedGraph strip = grid(80, 5);
  Random random(1);
  const std::vector<char> side = bisect(strip, random);
  const auto n_first = std::count(side.begin(), side.end(), 0);
  EXPECT_LE(std::max(n_first, 400 - n_first), 220) << "0.55 of the weight";
  EXPECT_EQ(cut_of(strip, side), 5);
}

// The least cut of a square of n × n into equal halves has n edges; into halves of at most 0.55 no fewer,
// since a corner of n²·0.45 vertices has more.
TEST(Bisect, ComesNearToTheLeastCutOfASquare) {
  const WeightedGraph square = grid(24, 24);
  Random random(2);
  const std::vector<char> side = bisect(square, random);
  const auto n_first = std::count(side.begin(), side.end(), 0);
  EXPECT_LE(std::max(n_first, 576 - n_first), 317);
  EXPECT_GE(cut_of(square, side), 24);
  EXPECT_LE(cut_of(square, side), 30);
}

// Heavy vertices are balanced by weight and not by number; heavy edges are not cut.
TEST(Bisect, CountsWeights) {
  WeightedGraph path = grid(40, 1);  // of weight 70; a half may have 39, the middle of the path parts 50
  std::fill(path.weight.begin(), path.weight.begin() + 10, 4);
  Random random(3);
  const std::vector<char> side = bisect(path, random);
  std::array<int, 2> weight{};
  for (int v = 0; v < 40; ++v) weight[side[v]] += path.weight[v];
  EXPECT_LE(std::max(weight[0], weight[1]), 39);
  EXPECT_EQ(cut_of(path, side), 1);
  WeightedGraph tied = grid(12, 1);
  for (int e = tied.first[5]; e < tied.first[6]; ++e) tied.edge_weight[e] = 9;
  for (int v : {4, 6})
    for (int e = tied.first[v]; e < tied.first[v + 1]; ++e)
      if (tied.list[e] == 5) tied.edge_weight[e] = 9;
  const std::vector<char> halves = bisect(tied, random);
  EXPECT_EQ(cut_of(tied, halves), 1);
}

TEST(Bisect, TakesGraphsOfSeveralComponents) {
  WeightedGraph pieces;
  for (int v = 0; v < 10; ++v) {
    pieces.first.push_back(0);
    pieces.weight.push_back(1);
  }
  Random random(4);
  const std::vector<char> side = bisect(pieces, random);
  EXPECT_EQ(std::count(side.begin(), side.end(), 0), 5);
}

// König: as many vertices as the largest matching has edges touch all edges. Between two rows of n vertices
// these are n; of a star, its middle alone.
TEST(VertexCover, TouchesEveryCutEdgeWithTheFewestVertices) {
  const auto size_of = [](const WeightedGraph& graph, const std::vector<char>& side) {
    const VertexCover cover(graph, side);
    int size = 0;
    for (int v = 0; v < graph.size(); ++v) {
      size += cover.contains(v) ? 1 : 0;
      for (int e = graph.first[v]; e < graph.first[v + 1]; ++e)
        EXPECT_TRUE(side[v] == side[graph.list[e]] || cover.contains(v) || cover.contains(graph.list[e]))
            << v;
    }
    return size;
  };
  std::vector<char> rows(14, 0);
  std::fill(rows.begin() + 7, rows.end(), 1);
  EXPECT_EQ(size_of(grid(7, 2), rows), 7);
  WeightedGraph star;
  star.list = {1, 2, 3, 4};
  star.first = {0, 4};
  star.weight = {1, 1, 1, 1, 1};
  for (int leaf = 1; leaf < 5; ++leaf) {
    star.list.push_back(0);
    star.first.push_back(4 + leaf);
  }
  star.edge_weight.assign(8, 1);
  EXPECT_EQ(size_of(star, {0, 1, 1, 1, 1}), 1);
  EXPECT_EQ(size_of(star, {1, 0, 0, 0, 0}), 1);
}

}  // namespace
}  // namespace batten
