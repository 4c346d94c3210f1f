#include <cmath>

#include <gtest/gtest.h>

#include "batten/subdivision/cage_polylines_detail.hpp"

namespace batten::detail {
namespace {

using Row = Eigen::RowVector3d;

/// Pieces of lengths 1, 3 and 4.
Points staircase() {
  Points points(4, 3);
  points << 0, 0, 0, 1, 0, 0, 1, 3, 0, 1, 3, 4;
  return points;
}

TEST(CagePolylines, FractionsAreThoseOfTheLength) {
  const Points points = staircase();
  EXPECT_EQ(lengths_along(points), (std::vector<double>{0, 1, 4, 8}));
  EXPECT_EQ(point_along(points, 0), Row(0, 0, 0));
  EXPECT_EQ(point_along(points, 0.25), Row(1, 1, 0));
  EXPECT_EQ(point_along(points, 0.75), Row(1, 3, 2));
  EXPECT_EQ(point_along(points, 1), Row(1, 3, 4));
}

// Points that repeat have a place of their own and no length: whatever fraction falls there is that place.
TEST(CagePolylines, RepeatedPointsHaveTheirPlace) {
  Points points(6, 3);
  points << 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0, 2, 0, 0;
  EXPECT_EQ(point_along(points, 0), Row(0, 0, 0));
  EXPECT_EQ(point_along(points, 0.5), Row(1, 0, 0));
  EXPECT_EQ(point_along(points, 1), Row(2, 0, 0));
  EXPECT_EQ(point_along(Points::Ones(3, 3), 0.5), Row(1, 1, 1));
}

TEST(CagePolylines, TheNearestPointOfAPointOnIt) {
  const Points points = staircase();
  for (const double fraction : {0.0, 0.1, 0.125, 0.3, 0.5, 0.8, 1.0})
    EXPECT_NEAR(nearest_fraction(points, point_along(points, fraction)), fraction, 1e-15);
  EXPECT_NEAR(nearest_fraction(points, Row(5, 2, 0)), 3.0 / 8, 1e-15);  // off the second piece
  EXPECT_EQ(nearest_fraction(Points::Zero(3, 3), Row(1, 0, 0)), 0.5);
}

// The two parts have the points of the whole, and one more each; a cut at a point keeps it once in each.
TEST(CagePolylines, PartsMeetAtTheCut) {
  const Points points = staircase();
  for (const double fraction : {0.05, 0.125, 0.3, 0.5, 0.9}) {
    const auto [first, second] = cut_polyline(points, fraction);
    EXPECT_NEAR(lengths_along(first).back(), 8 * fraction, 1e-14);
    EXPECT_NEAR(lengths_along(second).back(), 8 * (1 - fraction), 1e-14);
    EXPECT_EQ(first.row(0), points.row(0));
    EXPECT_EQ(second.bottomRows(1), points.bottomRows(1));
    EXPECT_EQ(first.bottomRows(1), second.row(0));
    const bool at_point = fraction == 0.125 || fraction == 0.5;
    EXPECT_EQ(first.rows() + second.rows(), at_point ? 5 : 6) << fraction;
  }
}

}  // namespace
}  // namespace batten::detail
