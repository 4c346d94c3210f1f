#include "batten/curves/gauss.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(GaussIntegral, IsExactForPolynomialsOfDegreeNine) {
  for (int degree = 0; degree <= 9; ++degree)
    EXPECT_NEAR(gauss_integral([&](double x) { return std::pow(x, degree); }), 1.0 / (degree + 1), 2e-16)
        << degree;
}

TEST(GaussIntegral, OfFifteenDigitsIsTheSameToFifteenDigits) {
  for (std::size_t k = 0; k < kGaussRule.size(); ++k) {
    EXPECT_NEAR(kGaussRuleOfFifteenDigits[k].place, kGaussRule[k].place, 1e-15);
    EXPECT_NEAR(kGaussRuleOfFifteenDigits[k].weight, kGaussRule[k].weight, 1e-15);
  }
}

// The error for f is (5!)⁴ / (11 (10!)³) f⁽¹⁰⁾, and (x¹⁰)⁽¹⁰⁾ = 10!: 1.43e-6, which no other weights at these
// places and no other places have.
TEST(GaussIntegral, MissesTheTenthPowerByTheErrorOfTheRule) {
  const double tenth = gauss_integral([](double x) { return std::pow(x, 10); });
  EXPECT_NEAR(1.0 / 11 - tenth, std::pow(120.0, 4) / (11 * std::pow(3628800.0, 2)), 1e-15);
}

}  // namespace
}  // namespace batten
