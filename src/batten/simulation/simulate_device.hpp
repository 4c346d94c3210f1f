#pragma once
#include <cstdint>

#include "batten/scan/sensor_log.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {

/// A simulated inertial device and the place where it is used.
struct DeviceModel {
  DeviceAxes axes;
  double gravity = 9.81;                    ///< m/s²
  double field_strength = 48;               ///< µT
  double inclination = 1.0471975511965976;  ///< below the horizon, radians; 60° as in Grenoble (S 3.4.2)
  /// raw = distortion · true + offset, in device axes.
  Eigen::Matrix3d accelerometer_distortion = Eigen::Matrix3d::Identity();
  Eigen::Vector3d accelerometer_offset = Eigen::Vector3d::Zero();  ///< m/s²
  Eigen::Matrix3d magnetometer_distortion = Eigen::Matrix3d::Identity();
  Eigen::Vector3d magnetometer_offset = Eigen::Vector3d::Zero();  ///< µT
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();       ///< rad/s
  double accelerometer_noise = 0;                                 ///< standard deviation per axis, m/s²
  double magnetometer_noise = 0;                                  ///< µT
  double gyroscope_noise = 0;                                     ///< rad/s
  double knocks = 0;  ///< fraction of tumble readings with an acceleration of the hand on top; [0, 1]
};

/// A device such as phones hold: noise of 0.02 m/s², 0.3 µT and 0.002 rad/s, zero errors of a few per cent of
/// g and of half the field, scales that differ by some per cent, soft iron with 5 % skew.
/// @param seed draws the distortion. @param noise multiplies the noise; 0: none.
DeviceModel make_device(std::uint64_t seed, double noise = 1);

/// What the device would have written while a simulated scan was taken: its frames seen by accelerometer and
/// magnetometer, its distances, and the angular rate of the true motion, which starts and stops smoothly at
/// every node. Frames that are wrong in the scan (noise, outliers, disturbance) are wrong in the same way
/// here.
SensorLog simulate_log(const TracedNetwork& traced, const SimulatedScan& simulated, const DeviceModel& device,
                       std::uint64_t seed);

/// A recording for calibration: the device is turned slowly over all sides for a minute, at 25 readings per
/// second, with two seconds of rest at both ends. Readings lie on no curve.
SensorLog simulate_tumble(const DeviceModel& device, std::uint64_t seed);

}  // namespace batten
