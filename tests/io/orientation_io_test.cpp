#include "batten/io/orientation_io.hpp"

#include "scratch.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace batten {
namespace {

// The columns that the documentation names; a reading without an orientation has empty cells.
TEST(OrientationIo, WritesARowPerReading) {
  OrientationEstimate estimate;
  estimate.quaternions.resize(2, 4);
  estimate.quaternions << Eigen::RowVector4d::Constant(std::numeric_limits<double>::quiet_NaN()),
      Eigen::RowVector4d(0.5, -0.5, 0.5, -0.5);
  estimate.tilt_deviation = Eigen::Vector2d(std::numeric_limits<double>::quiet_NaN(), radians(0.25));
  estimate.heading_deviation = Eigen::Vector2d(std::numeric_limits<double>::quiet_NaN(), radians(1.5));
  const std::string path = test::scratch() + "/orientation.csv";
  write_orientations(estimate, Eigen::Vector2d(0, 0.0035), path);
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "time_s,w,x,y,z,tilt_sd_deg,heading_sd_deg");
  std::getline(in, line);
  EXPECT_EQ(line, "0,,,,,,");
  std::getline(in, line);
  EXPECT_EQ(line, "0.0035,0.500000000,-0.500000000,0.500000000,-0.500000000,0.25,1.5");
  EXPECT_FALSE(std::getline(in, line));
}

// A device in the hand, held against an optical reference (see data/README.md beside the recording). Gravity
// and field reading by reading are off by 6.3 degrees, 3.0 of them tilt; the targets are those of the
// project.
TEST(OrientationIo, ASharedRecordingAgreesWithItsOpticalReference) {
  const std::string path = BATTEN_SHARED_DATA "/imu/broad_02_undisturbed_slow_rotation_B.csv.gz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no public data in ../shared/data/imu";
  const SensorLog log = read_sensor_log(path, "time=t_s,acc=ax:ay:az,gyr=gx:gy:gz,mag=mx:my:mz");
  // The reference is read by the same reader, as if it were readings.
  const SensorLog reference = read_sensor_log(path, "time=t_s,acc=qx:qy:qz,gyr=qw:movement:px");
  const OrientationEstimate estimate = estimate_orientation(log);
  double total = 0, tilt = 0, n = 0;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const Eigen::Vector3d v = reference.accelerometer.row(i);
    const double w = reference.gyroscope(i, 0);
    if (reference.gyroscope(i, 1) != 1 || !v.allFinite() || std::isnan(w)) continue;
    // Its world is east, north, up.
    const Eigen::Quaterniond truth =
        Eigen::AngleAxisd(-kPi / 2, Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(w, v.x(), v.y(), v.z());
    const auto q = estimate.quaternions.row(i);
    const Eigen::Quaterniond error = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * truth.conjugate();
    total += std::pow(2 * std::acos(std::min(1.0, std::abs(error.w()))), 2);
    tilt += std::pow(2 * std::acos(std::min(1.0, std::hypot(error.w(), error.z()))), 2);
    n += 1;
  }
  EXPECT_EQ(n, 15714);
  EXPECT_LE(degrees(std::sqrt(total / n)), 0.9);
  EXPECT_LE(degrees(std::sqrt(tilt / n)), 0.4);
}

}  // namespace
}  // namespace batten
