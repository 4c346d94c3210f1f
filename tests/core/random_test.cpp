#include "batten/core/random.hpp"

#include <set>

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(Random, RepeatsItselfForTheSameSeedAndStream) {
  Random a(7), b(7), c(8), d(7, 1);
  bool differs_by_seed = false, differs_by_stream = false;
  for (int i = 0; i < 100; ++i) {
    const auto x = a.bits();
    EXPECT_EQ(x, b.bits());
    differs_by_seed |= x != c.bits();
    differs_by_stream |= x != d.bits();
  }
  EXPECT_TRUE(differs_by_seed);
  EXPECT_TRUE(differs_by_stream);
}

// Mean 0, variance 1, fourth moment 3 of the standard normal; 4 standard errors at 200,000 draws.
TEST(Random, NormalHasTheMomentsOfTheStandardNormal) {
  Random random(1);
  constexpr int kDraws = 200000;
  double m1 = 0, m2 = 0, m4 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    m1 += x;
    m2 += x * x;
    m4 += x * x * x * x;
  }
  EXPECT_NEAR(m1 / kDraws, 0, 4 / std::sqrt(kDraws));
  EXPECT_NEAR(m2 / kDraws, 1, 4 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(m4 / kDraws, 3, 4 * std::sqrt(96.0 / kDraws));
}

TEST(Random, BelowReachesEveryValueAndNoOther) {
  Random random(3);
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 1000; ++i) seen.insert(random.below(7));
  EXPECT_EQ(seen, (std::set<std::uint64_t>{0, 1, 2, 3, 4, 5, 6}));
}

TEST(Random, DirectionsAreUnitAndBalanced) {
  Random random(5);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 10000; ++i) {
    const Eigen::Vector3d d = random.direction();
    EXPECT_NEAR(d.norm(), 1, 1e-14);
    sum += d;
  }
  EXPECT_LT(sum.norm() / 10000, 0.03);  // a random walk of 10,000 unit steps: 4 × 0.0058
}

}  // namespace
}  // namespace batten
