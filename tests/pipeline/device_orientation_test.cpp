#include "batten/pipeline/device_orientation.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/simulation/simulate_device.hpp"

namespace batten {
namespace {

// A tumbling device whose gyroscope has a known bias.
SensorLog tumble(const Eigen::Vector3d& bias) {
  DeviceModel device;
  device.gyroscope_bias = bias;
  return simulate_tumble(device, 1);
}

TEST(DeviceOrientation, OffersBothEstimates) {
  const Eigen::Vector3d bias(0.01, -0.02, 0.005);
  const SensorLog log = tumble(bias);
  for (const bool causal : {false, true}) {
    const DeviceOrientation result = device_orientation(log, {.estimate = {}, .causal = causal});
    EXPECT_EQ(result.estimate.quaternions.rows(), log.n_readings());
    EXPECT_LT((result.estimate.gyroscope_bias - bias).norm(), 0.002);
    EXPECT_EQ(result.estimate.iterations > 0, !causal);
  }
}

TEST(DeviceOrientation, CanBeCancelledAndRefusesBadOptions) {
  const SensorLog log = tumble({0, 0, 0});
  for (const char* stage : {"filtering", "smoothing"}) {
    const Progress stop([&](std::string_view name, double) { return name != stage; });
    EXPECT_THROW(device_orientation(log, {}, stop), Cancelled) << stage;
  }
  DeviceOrientationOptions options;
  options.estimate.reach = -1;
  EXPECT_THROW(device_orientation(log, options), InvalidInput);
}

}  // namespace
}  // namespace batten
