#include "batten/curves/hermite_cubic.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::RowVector3d;

RowVector3d cubic(double x) {
  return {1 - x + 2 * x * x * x, 3 * x * x - x * x * x, 5};
}
RowVector3d cubic_slope(double x) {
  return {-1 + 6 * x * x, 6 * x - 3 * x * x, 0};
}

TEST(HermiteCubic, ReproducesCubicsOverAnyPiece) {
  const double a = -0.3, b = 1.9;
  const HermiteCubic piece{b - a, cubic(a), cubic(b), cubic_slope(a), cubic_slope(b)};
  for (const double t : {0.0, 0.2, 0.5, 0.77, 1.0}) {
    const double x = a + t * (b - a);
    EXPECT_NEAR((piece.at(t) - cubic(x)).norm(), 0, 1e-14);
    EXPECT_NEAR((piece.derivative(t) - cubic_slope(x)).norm(), 0, 1e-14);
    EXPECT_NEAR((piece.second_derivative(t) - RowVector3d(12 * x, 6 - 6 * x, 0)).norm(), 0, 1e-13);
  }
}

TEST(HermiteCubic, HasTheLengthOfAStraightLineWhateverItsSpeed) {
  const RowVector3d along(2, -1, 2);  // of length 3; the speeds at the ends differ, neither turns back
  const HermiteCubic piece{4, RowVector3d(1, 1, 1), RowVector3d(1, 1, 1) + along, 0.1 * along, 0.5 * along};
  EXPECT_NEAR(piece.length(), 3, 1e-14);
}

// Pieces by arc length with the circle's own tangents. Positions and slopes are exact at the knots, so that
// the error of the speed is of fourth order.
TEST(HermiteCubic, LengthOfACircleConvergesAtFourthOrder) {
  const auto error = [](int n) {
    double length = 0;
    const double h = 2 * kPi / n;
    for (int i = 0; i < n; ++i) {
      const double a = i * h, b = a + h;
      length += HermiteCubic{
          h,
          {std::cos(a), std::sin(a), 0},
          {std::cos(b), std::sin(b), 0},
          {-std::sin(a), std::cos(a), 0},
          {-std::sin(b), std::cos(b),
           0}}.length();
    }
    return std::abs(length - 2 * kPi);
  };
  EXPECT_NEAR(std::log2(error(16) / error(32)), 4, 0.05);
}

}  // namespace
}  // namespace batten
