#include "batten/capture/simulated_device.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/capture/line_protocol.hpp"
#include "batten/core/error.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten::test {
namespace {

const DeviceMotion& sphere_motion() {
  static const DeviceMotion motion = [] {
    const TracedNetwork traced = trace_shape(AnalyticShape::Sphere);
    SimulateOptions options;
    options.step = 0.01;
    return DeviceMotion(simulate_log(traced, simulate_scan(traced, options), DeviceModel(), 0));
  }();
  return motion;
}

// The rate of the gyroscope is the derivative of the orientation, in device axes.
TEST(DeviceMotion, TurnsAtTheRateThatItTells) {
  const DeviceMotion& motion = sphere_motion();
  double greatest = 0;
  for (double t = 0.01; t < motion.duration(); t += 0.0317) {
    constexpr double kStep = 1e-5;
    const Eigen::Vector3d turn =
        so3_log(motion.at(t - kStep).orientation.transpose() * motion.at(t + kStep).orientation) /
        (2 * kStep);
    const Eigen::Vector3d rate = motion.at(t).rate;
    greatest = std::max(greatest, rate.norm());
    // Between two readings the rate is constant; at a reading it may jump.
    if ((motion.at(t - kStep).rate - motion.at(t + kStep).rate).norm() < 1e-3 * (1 + rate.norm())) {
      EXPECT_LT((turn - rate).norm(), 1e-3 * (1 + rate.norm())) << t;
    }
  }
  EXPECT_GT(greatest, 0.1);
}

TEST(DeviceMotion, RollsForwardAlone) {
  const DeviceMotion& motion = sphere_motion();
  double last = 0;
  for (double t = 0; t < motion.duration() + 1; t += 0.01) {
    const double distance = motion.at(t).distance;
    EXPECT_GE(distance, last - 1e-12);
    last = distance;
  }
  double length = 0;
  for (const TracedCurve& curve : trace_shape(AnalyticShape::Sphere).curves) length += curve.path->length();
  EXPECT_NEAR(last, length, 1e-9);
}

TEST(SimulatedDevice, AnswersTheSameRequestsInTheSameWay) {
  SimulatedDeviceOptions options;
  options.flip = 0.01;
  options.late = 0.1;
  const auto run = [&] {
    SimulatedDevice device(sphere_motion(), options);
    std::string all;
    for (std::int64_t t = 0; t < 2000000; t += 10000) {
      device.receive("Q", t);
      all += device.transmit(t + 5000);
    }
    return all;
  };
  EXPECT_EQ(run(), run());
}

TEST(SimulatedDevice, SlippingWheelsCountLess) {
  SimulatedDeviceOptions plain, slipping;
  slipping.slip = {2, 5};
  slipping.slip_share = 0.4;
  const auto ticks_at_end = [](const SimulatedDeviceOptions& options) {
    SimulatedDevice device(sphere_motion(), options);
    device.receive("Q", 0);
    device.transmit(100000);
    device.receive("Q", 9000000);
    return decode_packet(device.transmit(9100000), options.form).ticks();
  };
  const double slipped = 0.4 * (sphere_motion().at(7).distance - sphere_motion().at(2).distance);
  EXPECT_GT(slipped, 0);
  EXPECT_NEAR(ticks_at_end(plain) - ticks_at_end(slipping), slipped / 0.0628 * 500, 1.01);
}

TEST(SimulatedDevice, SpeaksTheLineProtocol) {
  SimulatedDeviceOptions options;
  options.kind = SimulatedDeviceOptions::Kind::Line;
  options.fused = true;
  SimulatedDevice device(sphere_motion(), options);
  device.receive("?\n", 0);
  LineSplitter splitter;
  const std::vector<std::string> lines = splitter.push(device.transmit(995000));
  EXPECT_GE(lines.size(), 199U);  // two for each of a hundred samples, the last of which may be on its way
  EXPECT_LE(lines.size(), 201U);
  int n_headers = 0;
  for (const std::string& line : lines)
    n_headers += std::holds_alternative<DeviceHeader>(parse_line(line)) ? 1 : 0;
  EXPECT_EQ(n_headers, 1);
}

TEST(SimulatedDeviceOptions, SayWhatIsWrong) {
  SimulatedDeviceOptions options;
  EXPECT_FALSE(options.problem().has_value());
  options.flip = 1.5;
  EXPECT_NE(options.problem()->find("flip"), std::string::npos);
  EXPECT_THROW(SimulatedDevice(sphere_motion(), options), InvalidInput);
  EXPECT_THROW(DeviceMotion(SensorLog{}), InvalidInput);
}

}  // namespace
}  // namespace batten::test
