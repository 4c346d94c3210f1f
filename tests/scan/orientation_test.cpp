#include "batten/scan/orientation.hpp"

#include "scan/motion_fixtures.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;
using fixtures::errors_of;
using fixtures::OrientationErrors;
using fixtures::waved;
using fixtures::WavedRecording;

OrientationErrors smoothed_errors(const WavedRecording& recording, const OrientationOptions& options = {}) {
  return errors_of(estimate_orientation(recording.log, options), recording.truth, recording.log);
}

// Without noise what remains is the trapezoidal rule between readings and what bounded velocity says of a
// motion that is not quite still in the mean.
TEST(Orientation, FollowsAnExactRecording) {
  const WavedRecording recording = waved({.noise = 0}, 1);
  const OrientationErrors errors = smoothed_errors(recording);
  EXPECT_LT(errors.total, 0.2);
  EXPECT_LT(errors.tilt, 0.1);
}

// A device pulled about at 5 m/s² per axis, at up to 2 m/s: up as the accelerometer shows it is off by tens
// of degrees.
TEST(Orientation, AccelerationsDoNotTiltIt) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const WavedRecording recording = waved({.turning = 2, .acceleration = 5}, seed);
    const OrientationErrors errors = smoothed_errors(recording);
    EXPECT_LT(errors.tilt, 0.45) << "seed " << seed;
    EXPECT_LT(errors.total, 0.6) << "seed " << seed;
  }
}

TEST(Orientation, FindsTheBiasOfTheGyroscope) {
  const Vector3d bias(radians(2.0), radians(-0.7), radians(1.1));
  const WavedRecording recording = waved({.bias = bias}, 4);
  const OrientationEstimate estimate = estimate_orientation(recording.log);
  EXPECT_LT((estimate.gyroscope_bias - bias).norm(), radians(0.05));
  // Nine tenths of a normal distribution of three dimensions lie within 2.5 deviations; twice that is a
  // fault.
  EXPECT_LT((estimate.gyroscope_bias - bias).norm(), 5 * estimate.gyroscope_bias_deviation.norm());
  EXPECT_LT(errors_of(estimate, recording.truth, recording.log).total, 0.5);
}

// A magnet of the strength of the field itself, fixed to the device: headings taken one by one are off by
// tens of degrees.
TEST(Orientation, AMagnetThatGoesWithTheDeviceIsFound) {
  const Vector3d magnet(25, -30, 15);
  const WavedRecording recording = waved({.magnet = magnet}, 5);
  const OrientationEstimate estimate = estimate_orientation(recording.log);
  EXPECT_LT((estimate.magnetometer_offset - magnet).norm(), 1);
  EXPECT_LT(errors_of(estimate, recording.truth, recording.log).total, 0.5);
  EXPECT_NEAR(estimate.field_strength, std::hypot(20.0, 44.0), 1);
}

TEST(Orientation, NoMagnetIsSeenWhereThereIsNone) {
  const OrientationEstimate estimate = estimate_orientation(waved({}, 6).log);
  EXPECT_EQ(estimate.magnetometer_offset, Vector3d::Zero());
}

// A magnet turns the field of a third of the recording by 60 degrees.
TEST(Orientation, AMagnetThatComesNearIsSetAside) {
  const WavedRecording recording =
      waved({.intruder = {-10, 26, 10}, .intrudes_from = 18, .intrudes_to = 30}, 7);
  const OrientationEstimate estimate = estimate_orientation(recording.log);
  EXPECT_GT(estimate.magnetometer_rejected, 0.25);
  EXPECT_LT(errors_of(estimate, recording.truth, recording.log).total, 1.2);
}

// The first heading is 0 by agreement; only the vertical is known.
TEST(Orientation, WithoutMagnetometerUpIsStillKnown) {
  const WavedRecording recording = waved({.turning = 2}, 8);
  const OrientationEstimate estimate = estimate_orientation(recording.log, {.magnetometer = false});
  EXPECT_LT(errors_of(estimate, recording.truth, recording.log).tilt, 0.3);
  EXPECT_FALSE(estimate.magnetometer_used);
  ASSERT_EQ(estimate.warnings.size(), 1U);
  EXPECT_NE(estimate.warnings[0].find("no magnetometer"), std::string::npos);
  // The turn between estimate and truth is one about the vertical, nearly the same all the time.
  const auto heading_error = [&](Eigen::Index i) {
    const auto q = estimate.quaternions.row(i);
    const Eigen::Matrix3d X = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const Eigen::Matrix3d D = X * recording.truth[static_cast<size_t>(i)].transpose();
    return std::atan2(D(1, 0), D(0, 0));
  };
  const double first = heading_error(1200), last = heading_error(recording.log.n_readings() - 1);
  EXPECT_LT(std::abs(std::remainder(last - first, 2 * kPi)), radians(2.0));
}

// Accelerometer and magnetometer at 10 Hz beside a gyroscope at 200, as phones write them: the readings are
// fewer, so that errors grow a little. Without accelerometer for eight seconds the gyroscope leads on.
TEST(Orientation, SensorsMayBeReadAtRatesOfTheirOwn) {
  WavedRecording recording = waved({.turning = 0.5, .acceleration = 0.5}, 13);
  SensorLog& log = recording.log;
  const auto error = [&](const OrientationEstimate& estimate) {
    EXPECT_TRUE(estimate.warnings.empty());
    return errors_of(estimate, recording.truth, log).total;
  };
  const double all = error(estimate_orientation(log)), causal = error(filter_orientation(log));
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    if (i % 20 != 0) log.accelerometer.row(i).setConstant(NAN);
    if (i % 20 != 0) log.magnetometer.row(i).setConstant(NAN);
  }
  EXPECT_LT(error(estimate_orientation(log)), 1.5 * all + 0.2);
  EXPECT_LT(error(filter_orientation(log)), 1.5 * causal + 0.2);
  for (Eigen::Index i = 0; i < log.n_readings(); ++i)
    if (log.time[i] > 20 && log.time[i] < 28) log.accelerometer.row(i).setConstant(NAN);
  EXPECT_LT(error(estimate_orientation(log)), 1.5 * all + 0.5);
}

// Another arrangement of the sensors in the same device is another way to write the same readings.
TEST(Orientation, DoesNotDependOnTheAxesOfTheDevice) {
  const WavedRecording recording = waved({.acceleration = 3, .bias = {0.01, 0, 0}}, 9);
  Eigen::Matrix3d turn;
  turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  SensorLog turned = recording.log;
  turned.gyroscope = recording.log.gyroscope * turn.transpose();
  turned.accelerometer = recording.log.accelerometer * turn.transpose();
  turned.magnetometer = recording.log.magnetometer * turn.transpose();
  const OrientationEstimate a = estimate_orientation(recording.log), b = estimate_orientation(turned);
  for (Eigen::Index i = 0; i < recording.log.n_readings(); i += 100) {
    const Eigen::Quaterniond p(a.quaternions(i, 0), a.quaternions(i, 1), a.quaternions(i, 2),
                               a.quaternions(i, 3));
    const Eigen::Quaterniond q(b.quaternions(i, 0), b.quaternions(i, 1), b.quaternions(i, 2),
                               b.quaternions(i, 3));
    EXPECT_LT(p.angularDistance(q * Eigen::Quaterniond(turn)), radians(0.01)) << "row " << i;
  }
}

TEST(Orientation, DeviationsCoverTheErrors) {
  int within = 0, all = 0;
  for (const std::uint64_t seed : {10, 11, 12}) {
    const WavedRecording recording = waved({.turning = 1.5, .acceleration = 4}, seed);
    const OrientationEstimate estimate = estimate_orientation(recording.log);
    for (Eigen::Index i = 1000; i < recording.log.n_readings(); i += 50) {
      const auto q = estimate.quaternions.row(i);
      const Eigen::Matrix3d X = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
      const double tilt =
          std::acos(std::min(1.0, X.row(2).dot(recording.truth[static_cast<size_t>(i)].row(2))));
      if (tilt < 2.45 * estimate.tilt_deviation[i]) ++within;  // 95 % of two dimensions
      ++all;
      EXPECT_LT(estimate.tilt_deviation[i], radians(1.0));
    }
  }
  EXPECT_GT(within, 0.9 * all);
}

TEST(Orientation, RowsWithoutSomeSensorsAreBridged) {
  WavedRecording recording = waved({}, 13);
  const double missing = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index i = 0; i < recording.log.n_readings(); ++i) {
    if (i % 2 == 1) recording.log.gyroscope.row(i).setConstant(missing);
    if (i % 3 != 0) recording.log.accelerometer.row(i).setConstant(missing);
    if (i % 10 != 0) recording.log.magnetometer.row(i).setConstant(missing);
  }
  const OrientationEstimate estimate = estimate_orientation(recording.log);
  EXPECT_TRUE(estimate.quaternions.allFinite());
  EXPECT_LT(errors_of(estimate, recording.truth, recording.log).total, 0.6);
  EXPECT_TRUE(estimate.warnings.empty());
}

// Two seconds without any reading: what came before and after is as good as without them, and it is told.
TEST(Orientation, ALongGapIsToldAndDoesNoHarmElsewhere) {
  WavedRecording recording = waved({}, 14);
  SensorLog& log = recording.log;
  log.gyroscope.middleRows(4000, 400).setConstant(std::numeric_limits<double>::quiet_NaN());
  const OrientationEstimate estimate = estimate_orientation(log);
  EXPECT_NEAR(estimate.longest_gap, 2, 0.02);
  ASSERT_EQ(estimate.warnings.size(), 1U);
  EXPECT_NE(estimate.warnings[0].find("silent"), std::string::npos);
  EXPECT_GT(estimate.heading_deviation[4200], 5 * estimate.heading_deviation[3000]);
  const auto q = estimate.quaternions.row(6000);
  const Eigen::Matrix3d X = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  EXPECT_LT(so3_log(recording.truth[6000].transpose() * X).norm(), radians(1.0));
}

TEST(Orientation, RefusesWhatCannotWork) {
  const WavedRecording good = waved({.duration = 6}, 15);
  const auto refused = [](const SensorLog& log, const OrientationOptions& options, const char* word) {
    try {
      estimate_orientation(log, options);
      ADD_FAILURE() << word;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  SensorLog log = good.log;
  log.gyroscope.setConstant(std::numeric_limits<double>::quiet_NaN());
  refused(log, {}, "gyroscope");
  log = good.log;
  log.accelerometer.setConstant(std::numeric_limits<double>::quiet_NaN());
  refused(log, {}, "accelerometer");
  log = good.log;
  log.time[100] = 0.001;
  refused(log, {}, "reading 101");
  log = good.log;
  log.time.setZero();
  refused(log, {}, "one time");
  refused(SensorLog(), {}, "gyroscope");
  refused(good.log, {.speed = 0}, "speed");
  refused(good.log, {.heading_deviation = -1.0}, "heading_deviation");
}

}  // namespace
}  // namespace batten
