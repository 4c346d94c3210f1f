#include "batten/curves/cubic_spline.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

CubicSpline circle(int n) {
  std::vector<double> knots;
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    const double angle = 2 * kPi * (i % n) / n;
    knots.push_back(2 * kPi * i / n);
    points.row(i) << std::cos(angle), std::sin(angle), 0;
  }
  return {knots, points, true};
}

CubicSpline zigzag(bool periodic) {
  Points points(5, 3);
  points << 0, 0, 0, 1, 2, 0, 2, -1, 1, 4, 0, 3, 0, 0, 0;
  return {{0, 0.7, 1.5, 3.1, 4}, points, periodic};
}

TEST(CubicSpline, GoesThroughItsValuesWithContinuousDerivatives) {
  for (const bool periodic : {false, true}) {
    const CubicSpline spline = zigzag(periodic);
    for (Eigen::Index i = 0; i < spline.n_pieces(); ++i) {
      EXPECT_NEAR((spline.at(i, 0) - spline.values().row(i).transpose()).norm(), 0, 1e-15);
      EXPECT_NEAR((spline.at(i, 1) - spline.values().row(i + 1).transpose()).norm(), 0, 1e-15);
      if (i + 1 < spline.n_pieces() || periodic) {
        EXPECT_NEAR((spline.derivative(i, 1) - spline.derivative((i + 1) % 4, 0)).norm(), 0, 1e-13);
      }
    }
    if (!periodic) {
      EXPECT_EQ(spline.second_derivatives().row(0).norm(), 0);
      EXPECT_EQ(spline.second_derivatives().row(4).norm(), 0);
    }
  }
}

// The second derivatives of the formula are those that it is made of: central differences of the derivative,
// exact for a cubic but for rounding.
TEST(CubicSpline, HasTheSecondDerivativesItReports) {
  const CubicSpline spline = zigzag(false);
  for (Eigen::Index i = 0; i < spline.n_pieces(); ++i) {
    const Vector3d middle =
        (spline.derivative(i, 0.75) - spline.derivative(i, 0.25)) / (0.5 * spline.width(i));
    const Vector3d mean =
        0.5 * (spline.second_derivatives().row(i) + spline.second_derivatives().row(i + 1)).transpose();
    EXPECT_NEAR((middle - mean).norm(), 0, 1e-12);
  }
}

TEST(CubicSpline, ReproducesStraightLines) {
  Points points(4, 3);
  for (const auto& [i, x] : {std::pair{0, 0.0}, {1, 0.2}, {2, 3.0}, {3, 3.5}}) points.row(i) << x, -2 * x, 1;
  const CubicSpline spline({0, 0.2, 3, 3.5}, points, false);
  EXPECT_NEAR((spline.at(1, 0.5) - Vector3d(1.6, -3.2, 1)).norm(), 0, 1e-14);
  EXPECT_NEAR(spline.length(1), 2.8 * std::sqrt(5.0), 1e-14);
  EXPECT_NEAR(spline.length(1, 0.25), 0.7 * std::sqrt(5.0), 1e-14);
}

TEST(CubicSpline, LengthOfACircleConvergesAtFourthOrder) {
  const auto error = [](int n) {
    const CubicSpline spline = circle(n);
    double length = 0;
    for (Eigen::Index i = 0; i < spline.n_pieces(); ++i) length += spline.length(i);
    return std::abs(length - 2 * kPi);
  };
  EXPECT_NEAR(std::log2(error(16) / error(32)), 4, 0.1);
}

}  // namespace
}  // namespace batten
