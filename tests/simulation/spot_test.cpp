#include "batten/simulation/spot.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace batten {
namespace {

// Read noise alone: σ² = 2 σ_n² / (π A²), of a Gaussian that is wide against a pixel (of σ = 3 to 2 %); shot
// noise alone: σ² = gain / (2 π A), whatever the width.
TEST(CentreBound, IsThatOfAWideGaussian) {
  const Spot spot{{30.3, 20.7}, 3.0, 200};
  const SensorNoise read{1.5, 0};
  const double variance = 1.5 * 1.5 + 1.0 / 12;
  EXPECT_NEAR(centre_bound(spot, read)(0, 0), 2 * variance / (M_PI * 200 * 200),
              2e-2 * variance / (200 * 200));
  const SensorNoise shot{0, 1e4};
  EXPECT_NEAR(centre_bound(spot, shot)(1, 1), 1e4 / (2 * M_PI * 200), 0.1);
  EXPECT_NEAR(centre_bound(spot, shot)(0, 1), 0, 1e-6);
}

TEST(CentreBound, ClippedPixelsTellNothing) {
  const Spot plain{{30.3, 20.7}, 1.0, 240}, clipped{{30.3, 20.7}, 1.0, 1e5};
  EXPECT_GT(centre_bound(clipped, {})(0, 0), 0);
  Spot tiny = plain;
  tiny.peak = 1e-9;
  EXPECT_GT(centre_bound(tiny, {})(0, 0), 1e5);
}

}  // namespace
}  // namespace batten
