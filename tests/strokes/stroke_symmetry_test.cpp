#include "batten/strokes/stroke_symmetry.hpp"

#include "network/sphere_network.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using fixtures::add_polyline;
using fixtures::line;

/// Two lines on both sides of x = 3, one in that plane, one across it.
CurveNetwork even() {
  CurveNetwork strokes;
  add_polyline(strokes, line({1, 0, 0}, {2, 4, 1}, 30));
  add_polyline(strokes, line({5, 0, 0}, {4, 4, 1}, 30));
  add_polyline(strokes, line({3, 0, 1}, {3, 4, 2}, 30));
  add_polyline(strokes, line({1, 0, 0}, {5, 0, 0}, 30));
  return strokes;
}

TEST(MirrorPlane, IsFoundWhereStrokesAreTheirOwnImage) {
  const auto plane = find_mirror_plane(even());
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->axis, 0);
  EXPECT_NEAR(plane->position, 3, 1e-9);
  CurveNetwork uneven = even();
  uneven.curves.erase(uneven.curves.begin());
  EXPECT_FALSE(find_mirror_plane(uneven));
  EXPECT_THROW(find_mirror_plane(CurveNetwork{}), InvalidInput);
}

TEST(MirroredStrokes, CompleteHalfASketchAndDoubleNothing) {
  const MirrorPlane plane{0, 3};
  EXPECT_EQ(with_mirrored_strokes(even(), plane).curves.size(), 4u);
  CurveNetwork half = even();
  half.curves.erase(half.curves.begin() + 1);
  const CurveNetwork whole = with_mirrored_strokes(half, plane);
  ASSERT_EQ(whole.curves.size(), 4u);
  const Eigen::RowVector3d end = whole.positions.row(whole.curves.back().vertices.front());
  EXPECT_LT((end - Eigen::RowVector3d(5, 0, 0)).norm(), 1e-12);
  EXPECT_TRUE(find_mirror_plane(whole));
  EXPECT_TRUE(with_mirrored_strokes(CurveNetwork{}, plane).curves.empty());
}

}  // namespace
}  // namespace batten
