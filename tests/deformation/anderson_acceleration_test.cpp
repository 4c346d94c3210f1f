#include <cmath>

#include <gtest/gtest.h>

#include "batten/deformation/anderson_acceleration_detail.hpp"

namespace batten::detail {
namespace {

/// g(x) = A x + b with A diagonal and three different entries; its fixed point is b / (1 − A).
struct LinearMap {
  Points factors, constant;

  LinearMap() : factors(2, 3), constant(2, 3) {
    factors << 0.95, 0.5, -0.8, 0.5, 0.95, -0.8;
    constant << 1, -2, 0.5, 3, 0.25, -1;
  }
  Points operator()(const Points& x) const { return factors.cwiseProduct(x) + constant; }
  Points fixed_point() const { return constant.array() / (1 - factors.array()); }
};

// On a linear map the method is GMRES with one plain step after it [walker2011]: three different factors are
// done in four steps, where plain steps have left 0.95⁴ of the error.
TEST(AndersonAcceleration, EndsOnALinearMapAfterAsManyStepsAsItHasFactors) {
  const LinearMap map;
  Points x = Points::Zero(2, 3);
  AndersonAcceleration acceleration(6);
  for (int step = 0; step < 4; ++step) acceleration.advance(x, map(x), 1);
  EXPECT_LT((x - map.fixed_point()).norm(), 1e-6 * map.fixed_point().norm());
}

TEST(AndersonAcceleration, TheFirstStepIsPlainAndForgettingMakesTheNextOneSo) {
  const LinearMap map;
  Points x = Points::Constant(2, 3, 0.3);
  AndersonAcceleration acceleration(6);
  for (int step = 0; step < 3; ++step) {
    const Points plain = x + 0.5 * (map(x) - x);
    acceleration.advance(x, map(x), 0.5);
    EXPECT_LT((x - plain).norm(), 1e-14) << step;
    acceleration.forget();
  }
}

// With one past step only, three factors take longer, but still the fixed point is reached and stays.
TEST(AndersonAcceleration, ConvergesWithLittleDepth) {
  const LinearMap map;
  Points x = Points::Zero(2, 3);
  AndersonAcceleration acceleration(1);
  for (int step = 0; step < 200; ++step) acceleration.advance(x, map(x), 0.5);
  EXPECT_LT((x - map.fixed_point()).norm(), 1e-9);
}

}  // namespace
}  // namespace batten::detail
