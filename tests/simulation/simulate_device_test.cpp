#include "batten/simulation/simulate_device.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Standard deviation of all numbers of a − b.
double deviation(const Points& a, const Points& b) {
  return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.size()));
}

// Without faults both vectors keep their lengths and the angle between them, however the device is turned:
// up · field = −sin I.
TEST(SimulateTumble, TurnsTwoVectorsOfTheWorldTogether) {
  DeviceModel device;
  device.inclination = radians(35.0);
  const SensorLog log = simulate_tumble(device, 3);
  ASSERT_GT(log.n_readings(), 1500);
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const Vector3d up = log.accelerometer.row(i), field = log.magnetometer.row(i);
    EXPECT_NEAR(up.norm(), device.gravity, 1e-12);
    EXPECT_NEAR(field.norm(), device.field_strength, 1e-11);
    EXPECT_NEAR(up.dot(field), -std::sin(device.inclination) * device.gravity * device.field_strength, 1e-9);
    low = low.cwiseMin(up);
    high = high.cwiseMax(up);
    EXPECT_EQ(log.curve[static_cast<size_t>(i)], SensorLog::kNone);
  }
  // Over all sides: every axis of the device has pointed well up and well down.
  EXPECT_LT(low.maxCoeff(), -0.7 * device.gravity);
  EXPECT_GT(high.minCoeff(), 0.7 * device.gravity);
}

// Two seconds of rest at both ends, in which nothing turns and only the bias is left of the rate.
TEST(SimulateTumble, RestsAtBothEnds) {
  DeviceModel device;
  device.gyroscope_bias = {0.01, -0.02, 0.03};
  const SensorLog log = simulate_tumble(device, 3);
  const double end = log.time[log.n_readings() - 1];
  int at_rest = 0;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    if (i > 0) {
      EXPECT_GT(log.time[i], log.time[i - 1]);
    }
    if (log.time[i] > 1.9 && log.time[i] < end - 1.9) continue;
    ++at_rest;
    EXPECT_LT((log.gyroscope.row(i).transpose() - device.gyroscope_bias).norm(), 1e-9) << i;
  }
  EXPECT_GE(at_rest, 90);  // 2 · 1.9 s at 25 readings per second, but for rounding
}

// raw = distortion · true + offset, for every reading and both sensors.
TEST(SimulateTumble, DistortsAsTheModelSays) {
  DeviceModel ideal, device = make_device(11, 0);
  const SensorLog truth = simulate_tumble(ideal, 5), raw = simulate_tumble(device, 5);
  ASSERT_EQ(truth.n_readings(), raw.n_readings());
  const Points acceleration = (truth.accelerometer * device.accelerometer_distortion.transpose()).rowwise() +
                              device.accelerometer_offset.transpose();
  const Points field = (truth.magnetometer * device.magnetometer_distortion.transpose()).rowwise() +
                       device.magnetometer_offset.transpose();
  EXPECT_LT((raw.accelerometer - acceleration).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((raw.magnetometer - field).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT(
      ((raw.gyroscope - truth.gyroscope).rowwise() - device.gyroscope_bias.transpose()).cwiseAbs().maxCoeff(),
      1e-12);
}

// Noise has the deviation that was asked for, in each sensor: √(2/n) = 2 % for n = 4,800 numbers.
TEST(SimulateTumble, NoiseHasItsDeviation) {
  DeviceModel device;
  const SensorLog clean = simulate_tumble(device, 7);
  device.accelerometer_noise = 0.02;
  device.magnetometer_noise = 0.3;
  device.gyroscope_noise = 0.002;
  const SensorLog noisy = simulate_tumble(device, 7);
  EXPECT_NEAR(deviation(noisy.accelerometer, clean.accelerometer) / 0.02, 1, 0.06);
  EXPECT_NEAR(deviation(noisy.magnetometer, clean.magnetometer) / 0.3, 1, 0.06);
  EXPECT_NEAR(deviation(noisy.gyroscope, clean.gyroscope) / 0.002, 1, 0.06);
}

// A device that is mounted otherwise sees the same world in its own axes: R times what the other sees.
TEST(SimulateLog, SeesTheWorldInItsOwnAxes) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  const SimulatedScan scan = simulate_scan(traced, {.step = 0.05});
  DeviceModel one, other;
  other.axes.forward = {0, -1, 0};
  other.axes.normal = {1, 0, 0};
  const SensorLog a = simulate_log(traced, scan, one, 5), b = simulate_log(traced, scan, other, 5);
  const Matrix3d R = other.axes.matrix() * one.axes.matrix().transpose();
  for (const auto& [x, y] :
       {std::pair(&a.accelerometer, &b.accelerometer), std::pair(&a.magnetometer, &b.magnetometer),
        std::pair(&a.gyroscope, &b.gyroscope)})
    EXPECT_LT((*x * R.transpose() - *y).cwiseAbs().maxCoeff(), 1e-11);
  // The frames of the scan are what gravity is seen in: up · t, up · N.
  Eigen::Index row = 0;
  for (const ScanCurve& curve : scan.scan.curves)
    for (Eigen::Index i = 0; i < curve.n_readings(); ++i, ++row) {
      EXPECT_NEAR(a.accelerometer.row(row).dot(one.axes.forward), one.gravity * curve.tangents(i, 2), 1e-12);
      EXPECT_NEAR(a.accelerometer.row(row).dot(one.axes.normal), one.gravity * curve.normals(i, 2), 1e-12);
      EXPECT_EQ(a.distance[row], curve.distances[i]);
    }
  EXPECT_EQ(row, a.n_readings());
}

// The rates of an ideal gyroscope, summed up over all rows of the log, are the turns of the true frames:
// along the curves and from the end of one to the start of the next. The trapezoidal rule at 100 Hz is good
// to 1e-4.
TEST(SimulateLog, AGyroscopeThatIsReadAllTheTimeSeesTheTrueTurns) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  const SimulatedScan scan = simulate_scan(traced, {.seed = 2, .step = 0.05, .orientation_noise = 0.03});
  DeviceModel device;
  device.axes.forward = {0, -1, 0};
  device.axes.normal = {1, 0, 0};
  const SensorLog readings = simulate_log(traced, scan, device, 5);
  device.gyroscope_rate = 100;
  const SensorLog log = simulate_log(traced, scan, device, 5);
  const Matrix3d to_frame = device.axes.matrix().transpose();
  std::vector<Matrix3d> truth;
  for (const auto& frames : scan.true_frames) truth.insert(truth.end(), frames.begin(), frames.end());
  Matrix3d X = truth.front();
  Eigen::Index reading = 0;
  int rows_of_gyroscope = 0;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    if (i > 0) {
      const Vector3d rate = 0.5 * (log.gyroscope.row(i - 1) + log.gyroscope.row(i));
      X = X * so3_exp((log.time[i] - log.time[i - 1]) * (to_frame * rate));
    }
    if (!log.accelerometer.row(i).allFinite()) {
      ++rows_of_gyroscope;
      continue;
    }
    EXPECT_EQ(log.time[i], readings.time[reading]);
    EXPECT_EQ(log.accelerometer.row(i), readings.accelerometer.row(reading));
    EXPECT_EQ(log.distance[i], readings.distance[reading]);
    EXPECT_LT(so3_log(X.transpose() * truth[static_cast<size_t>(reading)]).norm(), 2e-3) << reading;
    ++reading;
  }
  EXPECT_EQ(reading, readings.n_readings());
  EXPECT_GT(rows_of_gyroscope, 5 * reading);
}

// The device rests at the end of the recording's first stay, so the mean there is the bias; what the walk and
// the warmth add is held against the same log without them, whose other numbers are the same.
TEST(AddGyroscope, HasTheErrorsThatWereAskedFor) {
  GyroscopeOptions options;
  options.walk = options.warming = options.noise = 0;
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  const SimulatedScan scan = simulate_scan(traced, {.step = 0.2});
  DeviceModel steady, warm, walking;
  add_gyroscope(steady, options, 3);
  options.warming = 3;
  add_gyroscope(warm, options, 3);
  options.warming = 0;
  options.walk = 1e-3;
  add_gyroscope(walking, options, 3);
  EXPECT_EQ(steady.gyroscope_bias, warm.gyroscope_bias);
  const SensorLog log = simulate_log(traced, scan, steady, 1);
  EXPECT_LT((log.gyroscope.row(1).transpose() - steady.gyroscope_bias).norm(), 1e-12);
  const SensorLog warmed = simulate_log(traced, scan, warm, 1),
                  walked = simulate_log(traced, scan, walking, 1);
  const Eigen::Index last = log.n_readings() - 1;
  const Vector3d by_warmth = (warmed.gyroscope - log.gyroscope).row(last);
  EXPECT_LT((by_warmth - (1 - std::exp(-log.time[last] / warm.warming_time)) * warm.gyroscope_warming).norm(),
            1e-12);
  const Points steps =
      (walked.gyroscope - log.gyroscope).bottomRows(last) - (walked.gyroscope - log.gyroscope).topRows(last);
  const double per_root_second = std::sqrt(steps.squaredNorm() / (3 * (log.time[last] - log.time[0])));
  EXPECT_NEAR(per_root_second / options.walk, 1, 0.05);
  options.scale = 0.6;
  EXPECT_THROW(add_gyroscope(steady, options, 3), InvalidInput);
  options.scale = 0;
  options.misalignment = 0;
  add_gyroscope(steady, options, 3);
  EXPECT_EQ(steady.gyroscope_distortion, Matrix3d::Identity());
}

TEST(MakeDevice, HasTheNoiseThatWasAskedFor) {
  const DeviceModel quiet = make_device(4, 0), plain = make_device(4), loud = make_device(4, 3);
  EXPECT_EQ(quiet.accelerometer_noise + quiet.magnetometer_noise + quiet.gyroscope_noise + quiet.knocks, 0);
  EXPECT_EQ(quiet.magnetometer_offset, plain.magnetometer_offset);
  EXPECT_DOUBLE_EQ(loud.gyroscope_noise, 3 * plain.gyroscope_noise);
  EXPECT_NE(make_device(5).magnetometer_offset, plain.magnetometer_offset);
  EXPECT_THROW(make_device(4, -1), InvalidInput);
}

}  // namespace
}  // namespace batten
