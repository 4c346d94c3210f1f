#include "batten/scan/calibration.hpp"

#include <cmath>
#include <filesystem>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/simulate_device.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kOffset(12, -30, 7);

Matrix3d soft_iron() {
  Matrix3d m;
  m << 1.15, 0.05, -0.03, 0.05, 0.92, 0.06, -0.03, 0.06, 1.02;
  return m;
}

/// Raw readings of a field of strength 48 from directions all over the sphere.
Points readings(int n, double noise, Random& random) {
  Points x(n, 3);
  for (int i = 0; i < n; ++i)
    x.row(i) = soft_iron() * (48 * random.direction()) + kOffset + noise * random.normal3();
  return x;
}

// The inverse of a symmetric distortion, scaled to determinant 1, is the only symmetric answer.
TEST(FitEllipsoid, RecoversOffsetScaleAndSoftIronExactly) {
  Random random(1);
  EllipsoidFitReport report;
  const SensorCalibration found = fit_ellipsoid(readings(500, 0, random), report);
  const Matrix3d exact = soft_iron().inverse() * std::cbrt(soft_iron().determinant());
  EXPECT_LT((found.offset - kOffset).norm(), 1e-8);
  EXPECT_LT((found.matrix - exact).norm(), 1e-9);
  EXPECT_NEAR(report.radius, 48 * std::cbrt(soft_iron().determinant()), 1e-7);
  EXPECT_NEAR(report.coverage, 1, 1e-12);
  EXPECT_EQ(report.outliers, 0);
}

// The spread of the estimate falls as 1/sqrt(n): errors stay below a few noise/sqrt(n/3).
TEST(FitEllipsoid, ErrorsFallWithTheNumberOfReadings) {
  Random random(2);
  for (const int n : {200, 20000}) {
    EllipsoidFitReport report;
    const SensorCalibration found = fit_ellipsoid(readings(n, 0.5, random), report);
    EXPECT_LT((found.offset - kOffset).norm(), 5 * 0.5 * std::sqrt(9.0 / n));
    EXPECT_NEAR(report.rms_residual, 0.5 / 48, 0.003);
  }
}

TEST(FitEllipsoid, AFewOutliersHaveNoSay) {
  Random random(3);
  Points x = readings(600, 0.2, random);
  for (int i = 0; i < 60; ++i) x.row(10 * i) += 60 * random.direction().transpose();
  EllipsoidFitReport report;
  const SensorCalibration found = fit_ellipsoid(x, report);
  EXPECT_LT((found.offset - kOffset).norm(), 0.2);
  EXPECT_GE(report.outliers, 50);
  EXPECT_LE(report.outliers, 65);
}

// The unit of the sensor is a factor on offset and radius, and nothing else.
TEST(FitEllipsoid, FollowsTheUnitOfTheReadings) {
  Random random(4);
  const Points x = readings(300, 0.3, random);
  EllipsoidFitReport report;
  const SensorCalibration one = fit_ellipsoid(x, report);
  for (const double factor : {1e-3, 1e3}) {
    const SensorCalibration other = fit_ellipsoid(factor * x, report);
    EXPECT_LT((other.offset - factor * one.offset).norm(), 1e-7 * factor * 48);
    EXPECT_LT((other.matrix - one.matrix).norm(), 1e-8);
  }
}

std::string complaint(const Points& x) {
  try {
    EllipsoidFitReport report;
    fit_ellipsoid(x, report);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FitEllipsoid, SaysWhichDirectionsAreMissing) {
  Random random(5);
  Points half = readings(2000, 0.2, random);
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < half.rows(); ++i)
    if (half(i, 2) > kOffset.z() + 20) half.row(n++) = half.row(i);
  half.conservativeResize(n, 3);
  EXPECT_NE(complaint(half).find("-z"), std::string::npos) << complaint(half);
}

TEST(FitEllipsoid, RefusesWhatShowsNoEllipsoid) {
  Random random(6);
  EXPECT_NE(complaint(Points(0, 3)).find("only 0 readings"), std::string::npos);
  EXPECT_NE(complaint(readings(20, 0, random)).find("only 20 readings"), std::string::npos);
  EXPECT_NE(complaint(Points::Zero(100, 3)).find("zero"), std::string::npos);
  EXPECT_NE(complaint(Points::Constant(100, 3, 7.0)).find("hardly change"), std::string::npos);
  EXPECT_NE(complaint(Points::Constant(100, 3, NAN)).find("only 0 readings"), std::string::npos);
  // Turned about one axis only: a circle lies on many ellipsoids.
  Points circle(200, 3);
  for (int i = 0; i < 200; ++i) circle.row(i) << 48 * std::cos(i), 48 * std::sin(i), 5;
  EXPECT_NE(complaint(circle), "accepted");
}

// A magnetometer mounted askew: no ellipsoid shows it, the constant angle to gravity does.
TEST(CalibrateDevice, FindsADistortionThatIsNotSymmetric) {
  DeviceModel device = make_device(11, 0);
  device.magnetometer_distortion = so3_exp({0.05, -0.08, 0.03}) * device.magnetometer_distortion;
  const DeviceCalibration found = calibrate_device(simulate_tumble(device, 1));
  const Matrix3d exact =
      device.magnetometer_distortion.inverse() * std::cbrt(device.magnetometer_distortion.determinant());
  EXPECT_LT((found.calibration.magnetometer.matrix - exact).norm(), 1e-6);
  EXPECT_NEAR(degrees(found.inclination), 60, 1e-5);
}

TEST(CalibrateDevice, RecoversASimulatedDeviceWithinItsNoise) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const DeviceModel device = make_device(seed);
    const DeviceCalibration found = calibrate_device(simulate_tumble(device, seed));
    EXPECT_LT((found.calibration.accelerometer.offset - device.accelerometer_offset).norm(), 0.01);
    EXPECT_LT((found.calibration.magnetometer.offset - device.magnetometer_offset).norm(), 0.1);
    EXPECT_LT((found.calibration.gyroscope_bias - device.gyroscope_bias).norm(), 0.01);
    EXPECT_LT(found.magnetometer.rms_residual, 0.01);
    EXPECT_GT(found.magnetometer.rms_before, 0.1);
    EXPECT_GT(found.accelerometer.coverage, 0.9);
    EXPECT_TRUE(found.warnings.empty());
  }
}

TEST(CalibrateDevice, NamesTheSensorThatCannotBeCalibrated) {
  SensorLog log = simulate_tumble(make_device(1), 1);
  log.magnetometer.setConstant(NAN);
  try {
    calibrate_device(log);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 12), "magnetometer");
  }
}

}  // namespace
}  // namespace batten
