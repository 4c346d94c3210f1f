#include "batten/scan/samples.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

SampledCurve curve(int n, bool closed, std::vector<int> at, std::vector<int> ids) {
  SampledCurve result;
  result.closed = closed;
  result.parameters = Eigen::VectorXd::LinSpaced(n, 2, 2 + 0.5 * (n - 1));
  result.frames.assign(static_cast<size_t>(n), Eigen::Matrix3d::Identity());
  result.weights = Eigen::VectorXd::Ones(n);
  result.node_samples = std::move(at);
  result.node_ids = std::move(ids);
  return result;
}

TEST(SampledScan, AddsUpItsCurves) {
  const SampledScan scan{{curve(5, false, {}, {}), curve(3, false, {}, {})}};
  EXPECT_EQ(scan.n_samples(), 8);
  EXPECT_DOUBLE_EQ(scan.curves[0].length(), 2);
  EXPECT_DOUBLE_EQ(scan.curves[0].step(3), 0.5);
  EXPECT_DOUBLE_EQ(scan.length(), 3);
}

// Nodes come first by their numbers, which curves share; then the seams of closed curves without nodes; then
// the rest along the curves. Every vertex is some sample's, and only nodes and seams are those of several.
TEST(NumberVertices, PutsNodesFirstThenSeamsThenTheRest) {
  const SampledScan scan{{curve(4, false, {0, 3}, {7, 2}), curve(4, true, {}, {}), curve(3, false, {1}, {7}),
                          curve(4, true, {0, 3}, {2, 2})}};
  const VertexNumbering numbering = number_vertices(scan);
  EXPECT_EQ(numbering.n_nodes, 3);              // the nodes and the one seam
  EXPECT_EQ(numbering.vertices[0].front(), 1);  // node 7 is the second of 2 and 7
  EXPECT_EQ(numbering.vertices[0].back(), 0);
  EXPECT_EQ(numbering.vertices[2][1], 1);
  EXPECT_EQ(numbering.vertices[3].front(), 0);
  EXPECT_EQ(numbering.vertices[3].back(), 0);
  EXPECT_EQ(numbering.vertices[1].front(), 2);
  EXPECT_EQ(numbering.vertices[1].back(), 2);
  std::vector<int> uses(static_cast<size_t>(numbering.n_vertices), 0);
  int next = 3;
  for (const std::vector<int>& vertices : numbering.vertices)
    for (const int v : vertices) {
      ASSERT_GE(v, 0);
      ASSERT_LT(v, numbering.n_vertices);
      if (uses[static_cast<size_t>(v)]++ == 0 && v >= 3) {
        EXPECT_EQ(v, next++);
      }
    }
  EXPECT_EQ(next, numbering.n_vertices);
  EXPECT_EQ(uses[0], 3);
  EXPECT_EQ(uses[1], 2);
  EXPECT_EQ(uses[2], 2);
}

// A frame each, but for the last one of a curve that closes smoothly; at a node every two visits are a pair.
TEST(NumberFrames, SharesTheFrameOfASmoothSeamAndPairsTheVisitsOfANode) {
  SampledScan scan{{curve(4, true, {}, {}), curve(3, false, {0, 2}, {0, 1}), curve(3, false, {1}, {1}),
                    curve(2, false, {0}, {1})}};
  scan.curves[0].smooth_seam = true;
  const FrameNumbering numbering = number_frames(scan);
  EXPECT_EQ(numbering.n_frames, 3 + 3 + 3 + 2);
  EXPECT_EQ(numbering.frames[0].front(), numbering.frames[0].back());
  // Node 1 is visited by three curves: three pairs; node 0 by one: none.
  EXPECT_EQ(numbering.node_pairs.size(), 3u);
  const int visits[3] = {numbering.frames[1][2], numbering.frames[2][1], numbering.frames[3][0]};
  for (int i = 0; i < 3; ++i)
    for (int j = i + 1; j < 3; ++j) {
      int found = 0;
      for (const auto& [a, b] : numbering.node_pairs)
        found += (a == visits[i] && b == visits[j]) || (a == visits[j] && b == visits[i]) ? 1 : 0;
      EXPECT_EQ(found, 1) << i << ", " << j;
    }
  scan.curves[0].smooth_seam = false;
  EXPECT_EQ(number_frames(scan).n_frames, 4 + 3 + 3 + 2);
}

}  // namespace
}  // namespace batten
