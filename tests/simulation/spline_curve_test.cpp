#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/simulation/spline_curve_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

SplineCurve circle(int n_knots) {
  std::vector<Vector3d> knots;
  for (int i = 0; i < n_knots; ++i)
    knots.emplace_back(std::cos(2 * kPi * i / n_knots), std::sin(2 * kPi * i / n_knots), 0);
  SplineCurve curve(knots, true);
  curve.set_normals(knots);
  return curve;
}

// Cubic splines approximate with the fourth power of the spacing.
TEST(SplineCurve, LengthOfACircleConvergesWithTheFourthPower) {
  const double coarse = std::abs(circle(16).length() - 2 * kPi);
  const double fine = std::abs(circle(32).length() - 2 * kPi);
  EXPECT_NEAR(std::log2(coarse / fine), 4, 0.2);
}

TEST(SplineCurve, IsAFunctionOfItsArcLength) {
  const SplineCurve curve = circle(24);
  EXPECT_EQ(curve.n_knots(), 24U);
  for (int i = 0; i < 100; ++i) {
    const double s = curve.length() * i / 100;
    const CurvePoint p = curve.at(s);
    EXPECT_LT((p.position - Vector3d(std::cos(s), std::sin(s), 0)).norm(), 1e-4);
    EXPECT_LT((p.tangent - Vector3d(-std::sin(s), std::cos(s), 0)).norm(), 1e-3);
    EXPECT_LT(std::abs(p.tangent.dot(p.normal)), 1e-14);
    if (i == 0) continue;
    constexpr double kStep = 1e-5;
    EXPECT_NEAR((curve.at(s + kStep).position - curve.at(s - kStep).position).norm(), 2 * kStep, 1e-13);
  }
  for (size_t i = 0; i < curve.n_knots(); ++i)
    EXPECT_LT((curve.at(curve.distance_of_knot(i)).tangent - curve.tangent_at_knot(i)).norm(), 1e-10);
}

// A straight line is its own spline; distances outside are moved to the nearer end.
TEST(SplineCurve, KeepsStraightLinesAndStopsAtTheirEnds) {
  SplineCurve line({{0, 0, 0}, {1, 0, 0}, {4, 0, 0}}, false);
  line.set_normals({Vector3d::UnitZ(), Vector3d::UnitZ(), Vector3d::UnitZ()});
  EXPECT_NEAR(line.length(), 4, 1e-14);
  EXPECT_EQ(line.n_knots(), 3U);
  EXPECT_LT((line.at(2.5).position - Vector3d(2.5, 0, 0)).norm(), 1e-14);
  EXPECT_LT((line.at(-1).position - Vector3d(0, 0, 0)).norm(), 1e-14);
  EXPECT_LT((line.at(9).position - Vector3d(4, 0, 0)).norm(), 1e-14);
  EXPECT_LT((line.at(2.5).normal - Vector3d::UnitZ()).norm(), 1e-14);
}

}  // namespace
}  // namespace batten::detail
