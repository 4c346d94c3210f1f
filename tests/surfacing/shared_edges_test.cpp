#include <set>

#include <gtest/gtest.h>

#include "batten/surfacing/patch_detail.hpp"

namespace batten {
namespace {

using detail::PatchMesh;

/// The square with corners 0 to 3 of a network, cut along its diagonal from 0 to 2.
PatchMesh cut_square() {
  PatchMesh mesh;
  mesh.network_vertices = {0, 1, 2, 3};
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
  // lengths(f, k) is opposite corner k.
  mesh.lengths.resize(2, 3);
  mesh.lengths << 1, std::sqrt(2.0), 1, 1, 1, std::sqrt(2.0);
  return mesh;
}

NetworkCycle square_cycle() {
  NetworkCycle cycle;
  cycle.loops.resize(1);
  cycle.loops[0].vertices = {0, 1, 2, 3};
  return cycle;
}

// Two sheets over the same square with the same diagonal: the second gets a vertex in its middle. In a unit
// square that halves a side of √2 and adds medians of the same length; Heron's areas stay ¼ each.
TEST(SplitSharedInnerEdges, TheSecondPatchGetsAVertexOnTheCommonDiagonal) {
  std::vector<PatchMesh> patches{cut_square(), cut_square()};
  detail::split_shared_inner_edges(patches, {square_cycle(), square_cycle()});
  EXPECT_EQ(patches[0].n_inner, 0);
  EXPECT_EQ(patches[0].triangles.rows(), 2);
  ASSERT_EQ(patches[1].n_inner, 1);
  ASSERT_EQ(patches[1].triangles.rows(), 4);
  std::set<int> outer;
  for (Eigen::Index f = 0; f < 4; ++f) {
    int with_middle = 0;
    for (int k = 0; k < 3; ++k) {
      with_middle += patches[1].triangles(f, k) == 4 ? 1 : 0;
      if (patches[1].triangles(f, k) != 4) outer.insert(patches[1].triangles(f, k));
      // The side opposite the middle is one of the square, the others half a diagonal.
      EXPECT_NEAR(patches[1].lengths(f, k), patches[1].triangles(f, k) == 4 ? 1 : std::sqrt(0.5), 1e-12)
          << f << ", " << k;
    }
    EXPECT_EQ(with_middle, 1) << f;
  }
  EXPECT_EQ(outer, (std::set<int>{0, 1, 2, 3}));
}

TEST(SplitSharedInnerEdges, EdgesThatNobodySharesStay) {
  std::vector<PatchMesh> patches{cut_square(), cut_square()};
  patches[1].triangles << 1, 2, 3, 1, 3, 0;  // along the other diagonal
  detail::split_shared_inner_edges(patches, {square_cycle(), square_cycle()});
  EXPECT_EQ(patches[0].n_inner + patches[1].n_inner, 0);
}

}  // namespace
}  // namespace batten
