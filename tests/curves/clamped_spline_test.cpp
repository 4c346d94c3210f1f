#include "batten/curves/clamped_spline.hpp"

#include <gtest/gtest.h>

#include "batten/curves/gauss.hpp"
#include "batten/curves/hermite_cubic.hpp"

namespace batten {
namespace {

using Eigen::RowVector3d;
using Eigen::Vector3d;

Eigen::VectorXd uneven_knots() {
  Eigen::VectorXd knots(6);
  knots << 0, 0.3, 1.1, 1.2, 2.9, 3.5;
  return knots;
}
Vector3d cubic_point(double x) {
  return {1 - x + 2 * x * x * x, 3 * x * x - x * x * x, 5 * x};
}
Vector3d cubic_tangent(double x) {
  return {-1 + 6 * x * x, 6 * x - 3 * x * x, 5};
}
Points samples(const Eigen::VectorXd& knots) {
  Points points(knots.size(), 3);
  for (Eigen::Index i = 0; i < knots.size(); ++i) points.row(i) = cubic_point(knots(i)).transpose();
  return points;
}
HermiteCubic piece(const Points& points, const Points& tangents, const Eigen::VectorXd& knots,
                   Eigen::Index i) {
  return {knots(i + 1) - knots(i), points.row(i), points.row(i + 1), tangents.row(i), tangents.row(i + 1)};
}
double bending(const Points& points, const Points& tangents, const Eigen::VectorXd& knots) {
  double sum = 0;
  for (Eigen::Index i = 0; i + 1 < knots.size(); ++i) {
    const HermiteCubic cubic = piece(points, tangents, knots, i);
    sum += cubic.width * gauss_integral([&](double t) { return cubic.second_derivative(t).squaredNorm(); });
  }
  return sum;
}

TEST(ClampedSpline, ReproducesCubicsOverUnevenKnots) {
  const Eigen::VectorXd knots = uneven_knots();
  const Points points = samples(knots);
  const ClampedSpline spline(points, knots);
  const Points tangents = spline.tangents(cubic_tangent(0), cubic_tangent(3.5));
  for (Eigen::Index i = 0; i < knots.size(); ++i)
    EXPECT_NEAR((tangents.row(i).transpose() - cubic_tangent(knots(i))).norm(), 0, 1e-12) << i;
}

TEST(ClampedSpline, PiecesMeetWithEqualSecondDerivatives) {
  const Eigen::VectorXd knots = uneven_knots();
  const Points points = samples(knots);
  const Points tangents = ClampedSpline(points, knots).tangents({3, 1, -2}, {0, -4, 1});
  for (Eigen::Index i = 0; i + 2 < knots.size(); ++i)
    EXPECT_NEAR((piece(points, tangents, knots, i).second_derivative(1) -
                 piece(points, tangents, knots, i + 1).second_derivative(0))
                    .norm(),
                0, 1e-11)
        << i;
}

// The quadratic in a and b against ∫|x''|², which Gauss's rule integrates exactly; differences, for both know
// the energy but for a constant. Two points and three are the ends of the recursion.
TEST(ClampedSpline, KnowsItsBendingEnergyAsAQuadraticOfItsEndTangents) {
  for (const Eigen::Index n : {2, 3, 6}) {
    const Eigen::VectorXd knots = uneven_knots().head(n);
    const Points points = samples(knots);
    const ClampedSpline spline(points, knots);
    const auto by_formula = [&](const Vector3d& a, const Vector3d& b) {
      return spline.aa() * a.squaredNorm() + 2 * spline.ab() * a.dot(b) + spline.bb() * b.squaredNorm() -
             2 * spline.pull_a().dot(a) - 2 * spline.pull_b().dot(b);
    };
    const Vector3d zero = Vector3d::Zero(), a(1, -2, 0.5), b(0.3, 2, -1);
    const double at_rest = bending(points, spline.tangents(zero, zero), knots);
    for (const auto& [from, to] : {std::pair{a, zero}, std::pair{zero, b}, std::pair{a, b}})
      EXPECT_NEAR(bending(points, spline.tangents(from, to), knots) - at_rest, by_formula(from, to),
                  1e-10 * (1 + at_rest))
          << n;
  }
}

}  // namespace
}  // namespace batten
