#include "batten/scan/orientation_filter.hpp"

#include "scan/motion_fixtures.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;
using fixtures::errors_of;
using fixtures::waved;
using fixtures::WavedRecording;

// The filter sees a reading after the other; the rows of filter_orientation() are what it said each time.
TEST(OrientationFilter, SaysOfEveryReadingWhatTheWholeLogGives) {
  const WavedRecording recording = waved({.duration = 10}, 1);
  const SensorLog& log = recording.log;
  const OrientationEstimate rows = filter_orientation(log);
  OrientationFilter filter;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const auto q =
        filter.add({log.time[i], log.accelerometer.row(i), log.gyroscope.row(i), log.magnetometer.row(i)});
    ASSERT_TRUE(q.has_value());
    const Eigen::Quaterniond row(rows.quaternions(i, 0), rows.quaternions(i, 1), rows.quaternions(i, 2),
                                 rows.quaternions(i, 3));
    ASSERT_LT(q->angularDistance(row), 1e-7);
  }
}

TEST(OrientationFilter, KeepsUpThroughMotionAndFindsTheBias) {
  const Vector3d bias(radians(1.5), radians(-1.0), radians(0.5));
  for (const std::uint64_t seed : {2, 3}) {
    const WavedRecording recording = waved({.turning = 1.5, .acceleration = 4, .bias = bias}, seed);
    const OrientationEstimate estimate = filter_orientation(recording.log);
    const auto errors = errors_of(estimate, recording.truth, recording.log);
    EXPECT_LT(errors.tilt, 1.5) << "seed " << seed;
    EXPECT_LT(errors.total, 3) << "seed " << seed;
    EXPECT_LT((estimate.gyroscope_bias - bias).norm(), radians(0.3)) << "seed " << seed;
    // The future helps: the smoother is better, never worse.
    const auto smooth = errors_of(estimate_orientation(recording.log), recording.truth, recording.log);
    EXPECT_LT(smooth.total, 0.7 * errors.total) << "seed " << seed;
  }
}

// A filter that started in a wrong field must not hold on to its heading for ever.
TEST(OrientationFilter, RecoversFromAMagnetAtTheStart) {
  const WavedRecording recording =
      waved({.duration = 90, .intruder = {-20, 20, 0}, .intrudes_from = 0, .intrudes_to = 6}, 4);
  const OrientationEstimate estimate = filter_orientation(recording.log);
  const auto q = estimate.quaternions.row(recording.log.n_readings() - 1);
  const Eigen::Matrix3d X = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  EXPECT_LT(so3_log(recording.truth.back().transpose() * X).norm(), radians(5.0));
}

TEST(OrientationFilter, WaitsForBothSensorsAndRefusesTimesThatFall) {
  OrientationFilter filter;
  EXPECT_FALSE(filter.add({.time = 0}).has_value());
  EXPECT_FALSE(filter.add({.time = 0.01, .accelerometer = Vector3d(0, 0, 9.81)}).has_value());
  EXPECT_TRUE(filter.add({.time = 0.02, .gyroscope = Vector3d::Zero()}).has_value());
  EXPECT_THROW(filter.add({.time = 0.01}), InvalidInput);
  EXPECT_THROW(OrientationFilter({.gyroscope_noise = 0}), InvalidInput);
}

}  // namespace
}  // namespace batten
