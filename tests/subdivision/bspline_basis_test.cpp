#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "batten/subdivision/bspline_basis_detail.hpp"

namespace batten::detail {
namespace {

/// Knots of every kind that patches have.
std::vector<std::vector<double>> all_knots() {
  std::vector<std::vector<double>> all;
  for (const bool begin : {false, true})
    for (const bool end : {false, true})
      for (const int isolation : {2, 4, 6}) all.push_back(graded_knots(begin, end, isolation));
  return all;
}

// 1/8 is the end of the irregular cell: twice, so that one derivative is continuous there.
TEST(BsplineBasis, KnotsHalveTowardsIrregularEnds) {
  EXPECT_EQ(graded_knots(false, false, 3), (std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(graded_knots(true, false, 3),
            (std::vector<double>{0, 0, 0, 0, 0.125, 0.125, 0.25, 0.5, 1, 1, 1, 1}));
  std::vector<double> mirrored = graded_knots(false, true, 3);
  std::reverse(mirrored.begin(), mirrored.end());
  for (double& knot : mirrored) knot = 1 - knot;
  EXPECT_EQ(mirrored, graded_knots(true, false, 3));
  const std::vector<double> both = graded_knots(true, true, 4);
  EXPECT_TRUE(std::is_sorted(both.begin(), both.end()));
  EXPECT_EQ(std::count(both.begin(), both.end(), 0.5), 1);
}

// Control points are polar forms at the arguments of their sites [ramshaw1989]; those of 1, t, t² and t³ are
// 1, (a + b + c) / 3, (a b + b c + c a) / 3 and a b c.
TEST(BsplineBasis, ReproducesCubicsFromTheirPolarForms) {
  for (const std::vector<double>& knots : all_knots())
    for (int k = 0; k <= 64; ++k) {
      const double t = k / 64.0;
      const BsplineBasis basis = bspline_basis(knots, t);
      double value[4] = {}, slope[4] = {};
      for (int i = 0; i < 4; ++i) {
        const auto [a, b, c] = control_site(knots, basis.first + i).arguments;
        const double polar[4] = {1, (a + b + c) / 3, (a * b + b * c + c * a) / 3, a * b * c};
        for (int degree = 0; degree < 4; ++degree) {
          value[degree] += basis.value[i] * polar[degree];
          slope[degree] += basis.derivative[i] * polar[degree];
        }
        EXPECT_GE(basis.value[i], 0);
      }
      for (int degree = 0; degree < 4; ++degree) {
        EXPECT_NEAR(value[degree], std::pow(t, degree), 1e-14);
        EXPECT_NEAR(slope[degree], degree == 0 ? 0 : degree * std::pow(t, degree - 1), 1e-12);
      }
    }
}

// The polynomial that gives a control point is that of a cell on which the point has a say.
TEST(BsplineBasis, SitesLieInTheSupportOfTheirBasisFunction) {
  for (const std::vector<double>& knots : all_knots())
    for (size_t i = 0; i + 4 < knots.size(); ++i) {
      const double inside = control_site(knots, static_cast<Eigen::Index>(i)).inside;
      EXPECT_GT(inside, knots[i]);
      EXPECT_LT(inside, knots[i + 4]);
      EXPECT_EQ(std::count(knots.begin(), knots.end(), inside), 0);
    }
}

TEST(BsplineBasis, BernsteinPolynomialsSumUpToOne) {
  for (const double t : {0.0, 0.2, 0.5, 1.0}) {
    double sum = 0, mean = 0;
    for (int i = 0; i < 4; ++i) {
      sum += bernstein(i, t);
      mean += bernstein(i, t) * i / 3;
    }
    EXPECT_NEAR(sum, 1, 1e-15);
    EXPECT_NEAR(mean, t, 1e-15);
  }
}

}  // namespace
}  // namespace batten::detail
