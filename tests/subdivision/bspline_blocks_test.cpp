#include "batten/subdivision/bspline_blocks.hpp"

#include "subdivision/limit_cages.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using cages::creased_box;
using cages::random_torus;
using Eigen::Vector3d;

ControlCage refined(const ControlCage& cage, int levels) {
  return subdivide(cage, {.levels = levels}).cage;
}

/// The patch among those with the corners of another, and how often it is turned against it; −1 where there
/// is none.
int turn_of(const BsplineSurface& surface, const BsplinePatch& patch, const Points& vertices,
            const BsplinePatch** found) {
  for (const BsplinePatch& candidate : surface.patches)
    for (int turn = 0; turn < 4; ++turn) {
      double far = 0;
      for (std::size_t k = 0; k < 4; ++k)
        far = std::max(far,
                       (surface.vertices.row(candidate.vertices[(k + static_cast<std::size_t>(turn)) % 4]) -
                        vertices.row(patch.vertices[k]))
                           .norm());
      if (far < 1e-9) {
        *found = &candidate;
        return turn;
      }
    }
  return -1;
}

std::array<double, 2> turned(double u, double v, int turn) {
  for (int k = 0; k < turn; ++k) std::tie(u, v) = std::pair(1 - v, u);
  return {u, v};
}

/// Every edge has the points of the side of both its patches, at the same parameters.
void expect_shared_edges(const BsplineSurface& surface) {
  std::vector<int> uses(surface.edges.size(), 0);
  for (std::size_t p = 0; p < surface.patches.size(); ++p) {
    const BsplinePatch& patch = surface.patches[p];
    for (int k = 0; k < 4; ++k) {
      const auto e = static_cast<std::size_t>(patch.edges[static_cast<std::size_t>(k)]);
      const BsplineEdge& edge = surface.edges[e];
      ++uses[e];
      EXPECT_TRUE(edge.patches[0] == static_cast<int>(p) || edge.patches[1] == static_cast<int>(p));
      const bool along = edge.vertices[0] == patch.vertices[static_cast<std::size_t>(k)];
      for (const double t : {0.0, 0.13, 0.5, 0.77, 1.0}) {
        const auto [u, v] = on_patch_side(k, t);
        EXPECT_LT((evaluate(edge.curve, along ? t : 1 - t) - evaluate(patch, u, v).position).norm(), 1e-9);
      }
    }
  }
  for (std::size_t e = 0; e < uses.size(); ++e)
    EXPECT_EQ(uses[e], surface.edges[e].patches[1] < 0 ? 1 : 2) << e;
}

// Four patches where a face of the cage was are one again: that of the cage itself.
TEST(JoinedBsplines, AreThoseOfTheCageBeforeItWasRefined) {
  for (const ControlCage& cage :
       {cages::cube(), cages::cube_with_sharp_edges(), creased_box(), cages::prism(5)}) {
    const ControlCage coarse = refined(cage, 1);  // quads, and every extraordinary vertex a corner
    const BsplineSurface wanted = limit_bsplines(coarse);
    const BsplineSurface joined = joined_bsplines(limit_bsplines(refined(coarse, 2)));
    expect_shared_edges(joined);
    EXPECT_LT(joined.patches.size(), wanted.patches.size());
    const BsplineSurface again = joined_bsplines(wanted);
    ASSERT_EQ(joined.patches.size(), again.patches.size());
    for (const BsplinePatch& patch : joined.patches) {
      const BsplinePatch* same = nullptr;
      const int turn = turn_of(again, patch, joined.vertices, &same);
      ASSERT_GE(turn, 0);
      for (const double u : {0.31, 0.5, 0.64})
        for (const double v : {0.29, 0.5, 0.71}) {
          const auto [s, t] = turned(u, v, turn);
          const PatchPoint here = evaluate(patch, u, v), there = evaluate(*same, s, t);
          EXPECT_LT((here.position - there.position).norm(), 1e-10);
          EXPECT_LT(here.along_u.cross(here.along_v)
                        .normalized()
                        .cross(there.along_u.cross(there.along_v).normalized())
                        .norm(),
                    1e-8);
        }
    }
  }
}

// A closed torus has no vertex at which a line must begin: it is cut into four, so that no face has a seam.
TEST(JoinedBsplines, RingsAreCutTwice) {
  const BsplineSurface joined = joined_bsplines(limit_bsplines(random_torus()));
  EXPECT_EQ(joined.patches.size(), 4u);
  EXPECT_EQ(joined.edges.size(), 8u);
  EXPECT_TRUE(joined.is_closed);
  for (const BsplinePatch& patch : joined.patches)
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NE(patch.vertices[k], patch.vertices[(k + 1) % 4]);
  expect_shared_edges(joined);
}

// Sharp edges stay edges, also where they run straight through regular vertices.
TEST(JoinedBsplines, SharpEdgesStayBetweenPatches) {
  const auto sharp_length = [](const BsplineSurface& surface) {
    double sum = 0;
    for (const BsplineEdge& edge : surface.edges)
      if (edge.is_sharp)
        for (int i = 0; i < 256; ++i)
          sum += (evaluate(edge.curve, (i + 1) / 256.0) - evaluate(edge.curve, i / 256.0)).norm();
    return sum;
  };
  const BsplineSurface patches = limit_bsplines(refined(creased_box(), 2)), joined = joined_bsplines(patches);
  EXPECT_GT(sharp_length(joined), 0);
  EXPECT_NEAR(sharp_length(joined), sharp_length(patches), 1e-4 * sharp_length(patches));
  EXPECT_LT(joined.patches.size() * 2, patches.patches.size());
}

}  // namespace
}  // namespace batten
