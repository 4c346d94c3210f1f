#include "batten/curves/bspline.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace batten {
namespace {

using Eigen::RowVector3d;

TEST(CubicBasis, SumsToOneAndIsNowhereNegative) {
  for (const bool periodic : {false, true})
    for (const double u : {0.0, 0.3, 1.0, 2.5, 3.999, 4.0}) {
      const CubicBasis basis = cubic_basis(u, 4, periodic);
      EXPECT_NEAR(std::accumulate(basis.values.begin(), basis.values.end(), 0.0), 1, 1e-15);
      for (const double value : basis.values) EXPECT_GE(value, 0);
    }
}

// The uniform cubic B-spline is 1/6, 4/6, 1/6 at its knots; a single clamped span has Bernstein's
// polynomials.
TEST(CubicBasis, HasTheKnownValues) {
  const CubicBasis uniform = cubic_basis(2, 5, true);
  EXPECT_EQ(uniform.first, 2);
  const double knots[] = {1.0 / 6, 4.0 / 6, 1.0 / 6, 0};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(uniform.values[k], knots[k], 1e-16);
  const CubicBasis bernstein = cubic_basis(0.25, 1, false);
  EXPECT_EQ(bernstein.first, 0);
  const double values[] = {27.0 / 64, 27.0 / 64, 9.0 / 64, 1.0 / 64};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(bernstein.values[k], values[k], 1e-16);
}

TEST(CubicBasis, SlopesAreThoseOfDifferences) {
  constexpr double kStep = 1e-6;
  for (const bool periodic : {false, true})
    for (const double u : {0.3, 1.5, 2.25, 3.8}) {
      const CubicBasis basis = cubic_basis(u, 4, periodic), before = cubic_basis(u - kStep, 4, periodic),
                       after = cubic_basis(u + kStep, 4, periodic);
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_NEAR(basis.slopes[k], (after.values[k] - before.values[k]) / (2 * kStep), 1e-9);
    }
  // Clamped: at the end the curve runs along its first two control points, three times as fast as over a
  // span.
  const CubicBasis end = cubic_basis(0, 4, false);
  EXPECT_NEAR(end.slopes[0], -3, 1e-14);
  EXPECT_NEAR(end.slopes[1], 3, 1e-14);
  EXPECT_NEAR(end.slopes[2], 0, 1e-14);
}

// Marsden's identity: with the blossom of a cubic at the inner knots as control points, here x³ with the
// product of three knots, the spline is that cubic.
TEST(BSplineCurve, ReproducesACubicByMarsdensIdentity) {
  BSplineCurve curve;
  curve.degree = 3;
  curve.knots = {0, 0, 0, 0, 0.5, 0.8, 2, 2, 2, 2};
  for (std::size_t i = 0; i + 4 < curve.knots.size(); ++i) {
    const double a = curve.knots[i + 1], b = curve.knots[i + 2], c = curve.knots[i + 3];
    curve.points.emplace_back((a + b + c) / 3, (a * b + b * c + c * a) / 3, a * b * c);
  }
  for (std::size_t span = 3; span < 6; ++span)
    for (const double t : {0.0, 0.4, 1.0}) {
      const double u = curve.knots[span] + t * (curve.knots[span + 1] - curve.knots[span]);
      EXPECT_NEAR((curve.at(u, span) - RowVector3d(u, u * u, u * u * u)).norm(), 0, 2e-15) << u;
    }
}

// Two implementations: the basis with its control points, and de Boor's triangle over the same knots.
TEST(BSplineCurve, AgreesWithTheCubicBasis) {
  constexpr int kSpans = 4;
  BSplineCurve curve;
  curve.degree = 3;
  for (int k = -3; k <= kSpans + 3; ++k) curve.knots.push_back(std::clamp(k, 0, kSpans));
  for (int i = 0; i < kSpans + 3; ++i) curve.points.emplace_back(i * i % 5, 2 - i % 3, i);
  for (const double u : {0.0, 0.6, 1.0, 2.2, 3.9}) {
    const CubicBasis basis = cubic_basis(u, kSpans, false);
    RowVector3d sum = RowVector3d::Zero();
    for (int k = 0; k < 4; ++k) sum += basis.values[k] * curve.points[basis.first + k];
    EXPECT_NEAR((curve.at(u, static_cast<std::size_t>(std::floor(u)) + 3) - sum).norm(), 0, 1e-14) << u;
  }
}

TEST(BSplineCurve, OfDegreeOneIsThePolygon) {
  const BSplineCurve curve{1, {0, 0, 1, 3, 3}, {{0, 0, 0}, {1, 0, 0}, {1, 4, 0}}};
  EXPECT_EQ(curve.at(2, 2), RowVector3d(1, 2, 0));
}

}  // namespace
}  // namespace batten
