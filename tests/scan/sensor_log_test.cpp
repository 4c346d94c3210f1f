#include "batten/scan/sensor_log.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate_device.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// The dish, whose curves point in many directions, some open and one a closed border.
struct Recording {
  TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  SimulatedScan simulated;
  SensorLog log;

  explicit Recording(const DeviceModel& device, SimulateOptions options = {}, double step = 0.02) {
    options.step = step;
    simulated = simulate_scan(traced, options);
    log = simulate_log(traced, simulated, device, 5);
  }
};

double largest_difference(const Scan& a, const Scan& b) {
  double largest = 0;
  for (size_t c = 0; c < a.curves.size(); ++c) {
    largest = std::max(largest, (a.curves[c].tangents - b.curves[c].tangents).cwiseAbs().maxCoeff());
    largest = std::max(largest, (a.curves[c].normals - b.curves[c].normals).cwiseAbs().maxCoeff());
    largest = std::max(largest, (a.curves[c].distances - b.curves[c].distances).cwiseAbs().maxCoeff());
  }
  return largest;
}

// An ideal device measures what the scan holds, whichever way it is mounted, and with either method; the
// noise of the frames passes through unchanged, since the sensors see the noisy frames.
TEST(ScanFromLog, GivesBackTheScanThatTheDeviceTook) {
  SimulateOptions options;
  options.orientation_noise = radians(2);
  options.odometer_error = 0.01;
  DeviceModel device;
  for (const auto& [forward, normal] :
       {std::pair(Vector3d(1, 0, 0), Vector3d(0, 0, 1)), std::pair(Vector3d(0, -1, 0), Vector3d(1, 0, 0))}) {
    device.axes.forward = forward;
    device.axes.normal = normal;
    const Recording recording(device, options);
    for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd}) {
      LogScanOptions log_options;
      log_options.method = method;
      const LogScan result = scan_from_log(recording.log, log_options);
      EXPECT_LT(largest_difference(result.scan, recording.simulated.scan), 1e-12);
      for (size_t c = 0; c < result.scan.curves.size(); ++c) {
        EXPECT_EQ(result.scan.curves[c].node_ids, recording.simulated.scan.curves[c].node_ids);
        EXPECT_EQ(result.scan.curves[c].node_readings, recording.simulated.scan.curves[c].node_readings);
        EXPECT_EQ(result.scan.curves[c].closed, recording.simulated.scan.curves[c].closed);
        EXPECT_EQ(result.scan.curves[c].boundary, recording.simulated.scan.curves[c].boundary);
      }
      EXPECT_TRUE(result.warnings.empty());
    }
  }
}

TEST(ScanFromLog, FindsTheInclinationUnlessItIsGiven) {
  DeviceModel device;
  device.inclination = radians(-35);  // south of the equator the field points up
  const Recording recording(device);
  const LogScan result = scan_from_log(recording.log);
  EXPECT_TRUE(result.inclination_estimated);
  EXPECT_NEAR(degrees(result.inclination), -35, 1e-9);
  LogScanOptions options;
  options.inclination = radians(-35);
  EXPECT_FALSE(scan_from_log(recording.log, options).inclination_estimated);
  options.inclination = radians(90);
  EXPECT_THROW(scan_from_log(recording.log, options), InvalidInput);
}

// X_i = X_{i−1} exp(g_i) holds for the true frames up to the error of the trapezoidal rule over one step. The
// steps next to a stop are left out: readings come by distance, so there the device gathers speed within one.
TEST(ScanFromLog, GyroscopeTurnsLeadFromFrameToFrame) {
  const Recording recording(DeviceModel(), {}, 0.004);
  const LogScan result = scan_from_log(recording.log);
  double squares = 0;
  double turns = 0;
  for (size_t c = 0; c < result.scan.curves.size(); ++c) {
    const auto& frames = recording.simulated.true_frames[c];
    EXPECT_TRUE(std::isnan(result.gyroscope_turns[c](0, 0)));
    const std::vector<double>& stops = recording.traced.curves[c].node_distances;
    const auto at_stop = [&](size_t i) {
      const double s = recording.simulated.true_distances[c][static_cast<Eigen::Index>(i)];
      return std::count(stops.begin(), stops.end(), s) > 0;
    };
    for (size_t i = 1; i < frames.size(); ++i) {
      if (at_stop(i - 1) || at_stop(i)) continue;
      const Vector3d turn = so3_log(frames[i - 1].transpose() * frames[i]);
      squares +=
          (turn - result.gyroscope_turns[c].row(static_cast<Eigen::Index>(i)).transpose()).squaredNorm();
      turns += turn.squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(squares / turns), 0.05);
}

TEST(ScanFromLog, ACalibrationUndoesTheDistortionOfTheDevice) {
  const DeviceModel device = make_device(3, 0);
  const Recording recording(device);
  const DeviceCalibration found = calibrate_device(simulate_tumble(device, 3));
  LogScanOptions options;
  EXPECT_GT(largest_difference(scan_from_log(recording.log, options).scan, recording.simulated.scan), 0.1);
  options.calibration = found.calibration;
  EXPECT_LT(largest_difference(scan_from_log(recording.log, options).scan, recording.simulated.scan), 1e-6);
}

TEST(ScanFromLog, LeavesOutIncompleteReadingsAndSaysSo) {
  Recording recording{DeviceModel()};
  recording.log.magnetometer.row(5).setConstant(NAN);
  const LogScan result = scan_from_log(recording.log);
  EXPECT_EQ(result.scan.curves[0].n_readings(), recording.simulated.scan.curves[0].n_readings() - 1);
  ASSERT_EQ(result.warnings.size(), 1U);
  // The first of three readings at a node is incomplete: the second one stands for it.
  recording.log.accelerometer.row(0).setConstant(NAN);
  EXPECT_EQ(scan_from_log(recording.log).scan.curves[0].node_readings[0], 0);
  recording.log.accelerometer.topRows(3).setConstant(NAN);
  EXPECT_THROW(scan_from_log(recording.log), InvalidInput);  // nothing is left of this node
}

TEST(ScanFromLog, TakesTimesWhereThereAreNoDistances) {
  Recording recording{DeviceModel()};
  recording.log.distance.setConstant(NAN);
  const LogScan result = scan_from_log(recording.log);
  EXPECT_TRUE(result.times_for_distances);
  EXPECT_EQ(result.scan.unit, "s");
  EXPECT_EQ(result.scan.curves[1].distances[0], 0);
  recording.log.distance[3] = 1;
  EXPECT_THROW(scan_from_log(recording.log), InvalidInput);  // some have one
}

TEST(ScanFromLog, RefusesLogsThatHoldNoScan) {
  const Recording recording{DeviceModel()};
  EXPECT_THROW(scan_from_log(SensorLog()), InvalidInput);
  for (int missing = 0; missing < 3; ++missing) {
    SensorLog log = recording.log;
    if (missing == 0) log.accelerometer.setConstant(NAN);
    if (missing == 1) log.magnetometer.setConstant(NAN);
    if (missing == 2) log.curves.clear();
    EXPECT_THROW(scan_from_log(log), InvalidInput) << missing;
  }
  SensorLog log = recording.log;
  log.distance.conservativeResize(3);
  EXPECT_THROW(scan_from_log(log), InvalidInput);
  log = recording.log;
  log.accelerometer.row(1).setZero();
  EXPECT_THROW(scan_from_log(log), InvalidInput);
}

}  // namespace
}  // namespace batten
