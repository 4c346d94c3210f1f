#include "batten/curves/polyline.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// The regular n-gon in a circle of radius 1, from (1, 0, 0) round to it again.
Points circle_points(int n) {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) points.row(i) << std::cos(2 * kPi * i / n), std::sin(2 * kPi * i / n), 0;
  return points;
}

Points corner() {
  Points points(3, 3);
  points << 0, 0, 0, 3, 0, 0, 3, 4, 0;
  return points;
}

// A side of the polygon is the chord 2 sin(π / n).
TEST(ArcLengths, OfAPolygonInACircleAreMultiplesOfItsChord) {
  const std::vector<double> arcs = arc_lengths(circle_points(24));
  ASSERT_EQ(arcs.size(), 25U);
  for (int i = 0; i <= 24; ++i) EXPECT_NEAR(arcs[i], i * 2 * std::sin(kPi / 24), 1e-14);
  EXPECT_TRUE(arc_lengths(Points(0, 3)).empty());
}

TEST(ArcLengths, ConvergeToTheCircleAtSecondOrder) {
  const auto error = [](int n) { return 2 * kPi - arc_lengths(circle_points(n)).back(); };
  EXPECT_NEAR(std::log2(error(64) / error(128)), 2, 0.01);
}

TEST(Polyline, IsWalkedByArcLengthAndHeldAtItsEnds) {
  const Polyline polyline(corner());
  EXPECT_EQ(polyline.length(), 7);
  EXPECT_EQ(polyline.at(1.5), Vector3d(1.5, 0, 0));
  EXPECT_EQ(polyline.at(3), Vector3d(3, 0, 0));
  EXPECT_EQ(polyline.at(5), Vector3d(3, 2, 0));
  EXPECT_EQ(polyline.at(-1), Vector3d(0, 0, 0));
  EXPECT_EQ(polyline.at(9), Vector3d(3, 4, 0));
  EXPECT_EQ(polyline.segment_at(2.9), 0);
  EXPECT_EQ(polyline.segment_at(3), 1);
  EXPECT_EQ(polyline.segment_at(7), 1);
}

TEST(Polyline, SamplesLieAtEqualDistancesWithExactEnds) {
  const Points samples = Polyline(corner()).sampled(7);
  ASSERT_EQ(samples.rows(), 8);
  EXPECT_EQ(samples.row(0), corner().row(0));
  EXPECT_EQ(samples.row(7), corner().row(2));
  for (int i = 1; i <= 7; ++i) EXPECT_NEAR((samples.row(i) - samples.row(i - 1)).norm(), 1, 1e-14);
}

TEST(Polyline, PartsOfACutAreAsLongAsTheWholeAndJoinAgain) {
  const Polyline polyline(corner());
  for (const double arc : {0.7, 3.0, 6.5}) {
    const auto [first, second] = cut(polyline, arc, polyline.at(arc));
    EXPECT_NEAR(first->length(), arc, 1e-14);
    EXPECT_NEAR(second->length(), 7 - arc, 1e-14);
    EXPECT_EQ(first->back(), second->front());
    EXPECT_NEAR(joined(*first, *second)->length(), 7, 1e-14);
  }
  // A point that the cut falls on is not repeated.
  EXPECT_EQ(cut(polyline, 3, polyline.at(3)).first->n_points(), 2);
  EXPECT_EQ(reversed(polyline)->front(), polyline.back());
  EXPECT_EQ(reversed(*reversed(polyline))->points(), polyline.points());
}

}  // namespace
}  // namespace batten
