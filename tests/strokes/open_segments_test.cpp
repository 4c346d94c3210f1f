#include <vector>

#include <gtest/gtest.h>

#include "batten/strokes/open_segments_detail.hpp"

namespace batten::detail {
namespace {

NetworkTopology topology_of(int n_nodes, const std::vector<std::pair<int, int>>& ends) {
  NetworkTopology topology;
  for (int n = 0; n < n_nodes; ++n) topology.nodes.push_back(n);
  for (const auto& [from, to] : ends) {
    NetworkSegment& segment = topology.segments.emplace_back();
    segment.from = from;
    segment.to = to;
  }
  return topology;
}

// Triangle 0 1 2, a twig 2-3-4 with a branch 3-5: all of the twig ends in nothing, from its tips on.
TEST(OpenSegments, TailsGoFromTheirTipsOn) {
  const NetworkTopology topology = topology_of(6, {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {3, 5}});
  OpenSegments open(topology);
  std::vector<int> tails = open.take_tails();
  ASSERT_EQ(tails.size(), 3U);
  EXPECT_EQ(tails.back(), 3);  // after both that hang on it
  for (int s = 0; s < 6; ++s) EXPECT_EQ(open.is_kept(s), s < 3) << s;
  EXPECT_TRUE(open.take_bridges().empty());
}

// Two triangles joined by a chain of two segments, a loop at the far one, and a pair of parallel segments.
TEST(OpenSegments, BridgesAreWhatNoOtherWayCloses) {
  const NetworkTopology topology = topology_of(
      8, {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 4}, {6, 6}, {6, 7}, {7, 6}});
  OpenSegments open(topology);
  EXPECT_TRUE(open.take_tails().empty());
  EXPECT_EQ(open.take_bridges(), (std::vector{3, 4}));
  EXPECT_FALSE(open.is_kept(3));
  EXPECT_TRUE(open.is_kept(8));
}

}  // namespace
}  // namespace batten::detail
