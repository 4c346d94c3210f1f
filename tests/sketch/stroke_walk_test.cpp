#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/sketch/stroke_walk_detail.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

Stroke unit_square(bool closed) {
  Stroke stroke;
  stroke.points.resize(4, 3);
  stroke.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
  stroke.closed = closed;
  return stroke;
}

TEST(StrokeWalk, ClosedStrokesComeRound) {
  const Stroke square = unit_square(true);
  const detail::StrokeWalk walk(square);
  EXPECT_EQ(walk.length(), 4);
  EXPECT_EQ(walk.arc(2), 2);
  EXPECT_LT((walk.at(3.25) - Vector3d(0, 0.75, 0)).norm(), 1e-15);
  EXPECT_LT((walk.at(-0.25) - Vector3d(0, 0.25, 0)).norm(), 1e-15);
  EXPECT_LT((walk.at(5.5) - Vector3d(1, 0.5, 0)).norm(), 1e-15);
}

TEST(StrokeWalk, OpenStrokesEndAtTheirEnds) {
  const Stroke path = unit_square(false);
  const detail::StrokeWalk walk(path);
  EXPECT_EQ(walk.length(), 3);
  EXPECT_EQ(walk.at(-1), Vector3d(0, 0, 0));
  EXPECT_EQ(walk.at(7), Vector3d(0, 1, 0));
  EXPECT_LT((walk.at(1.5) - Vector3d(1, 0.5, 0)).norm(), 1e-15);
}

// What is near the last point kept is dropped, not what is near its neighbour: slow steps add up.
TEST(StrokeWalk, RepeatsAreCountedFromTheLastPointKept) {
  Points points(5, 3);
  points << 0, 0, 0, 0.6, 0, 0, 1.2, 0, 0, 1.8, 0, 0, 2.4, 0, 0;
  const Points kept = detail::without_repeats(points, 1);
  ASSERT_EQ(kept.rows(), 3);
  EXPECT_EQ(kept(1, 0), 1.2);
  EXPECT_EQ(kept(2, 0), 2.4);
}

// The cosine alone would lose half of the digits of small angles.
TEST(StrokeWalk, SmallAnglesKeepTheirDigits) {
  EXPECT_NEAR(detail::angle_between({1, 0, 0}, {1, 1e-9, 0}), 1e-9, 1e-18);
  EXPECT_NEAR(detail::angle_between({2, 0, 0}, {0, 0, 3}), kPi / 2, 1e-15);
  EXPECT_NEAR(detail::angle_between({1, 0, 0}, {-5, 0, 0}), kPi, 1e-15);
}

}  // namespace
}  // namespace batten
