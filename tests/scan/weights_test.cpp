#include "batten/scan/weights.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

// A sample of k readings has the k-th part of their variance; the weights are that over the variances of the
// shape. Noise twice as large asks for four times the smoothing.
TEST(WeightsOf, AreTheRatiosOfVariances) {
  NoiseModel noise;
  noise.white = 0.02;
  noise.stretch = 0.5;
  noise.bending = 4;
  const RegressionWeights one = weights_of(noise, 1);
  EXPECT_DOUBLE_EQ(one.lambda, 0.0004 / 0.5);
  EXPECT_DOUBLE_EQ(one.mu, 0.0004 / 4);
  EXPECT_DOUBLE_EQ(weights_of(noise, 4).lambda, one.lambda / 4);
  EXPECT_DOUBLE_EQ(weights_of(noise, 4).mu, one.mu / 4);
  noise.white *= 2;
  EXPECT_DOUBLE_EQ(weights_of(noise, 4).mu, one.mu);
}

// docs/methods.md#regression: λ' = λ h.
TEST(ScaledWeight, GrowsWithTheStep) {
  EXPECT_DOUBLE_EQ(scaled_weight(3, 0.25), 0.75);
  EXPECT_EQ(scaled_weight(0, 0.25), 0);
}

}  // namespace
}  // namespace batten
