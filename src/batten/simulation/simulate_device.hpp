#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "batten/core/units.hpp"
#include "batten/scan/sensor_log.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {

/// A simulated inertial device and the place where it is used.
struct DeviceModel {
  DeviceAxes axes;
  double gravity = kUsualGravity;           ///< m/s²
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
  /// Readings of the gyroscope per second while curves are drawn and between them, in rows of their own; 0:
  /// only where the other sensors are read.
  double gyroscope_rate = 0;
  /// reading = distortion · true rate + bias + walk + temperature: scale and misalignment of the axes.
  Eigen::Matrix3d gyroscope_distortion = Eigen::Matrix3d::Identity();
  double gyroscope_walk = 0;  ///< the bias walks at random: rad/s/√s per axis
  /// What the bias has moved by once the device is warm: it comes up as 1 − exp(−t / warming_time).
  Eigen::Vector3d gyroscope_warming = Eigen::Vector3d::Zero();  ///< rad/s
  double warming_time = 300;                                    ///< seconds; above 0
};

/// How large the errors of a gyroscope are; each is drawn for a device by add_gyroscope(). The defaults are
/// those of small silicon gyroscopes at a hundred readings per second.
struct GyroscopeOptions {
  double rate = 100;            ///< readings per second; (0, 10000]
  double bias = 0.01;           ///< deviation of the bias per axis, rad/s
  double walk = 2e-5;           ///< of its random walk, rad/s/√s
  double scale = 0.005;         ///< deviation of the error of scale per axis
  double misalignment = 0.005;  ///< deviation of each angle between the axes and those of the device, radians
  double temperature = 0.0005;  ///< deviation of the change of the bias with temperature per axis, rad/s/K
  double warming = 3;           ///< by how much the device grows warmer while it is used, kelvin
  double noise = 0.002;         ///< white, of one reading per axis, rad/s

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A device such as phones hold: noise of 0.02 m/s², 0.3 µT and 0.002 rad/s, zero errors of a few per cent of
/// g and of half the field, scales that differ by some per cent, soft iron with 5 % skew.
/// @param seed draws the distortion. @param noise multiplies the noise; 0: none.
DeviceModel make_device(std::uint64_t seed, double noise = 1);

/// Gives a device a gyroscope that is read all the time, its errors drawn from the options.
/// @throws InvalidInput when an option is out of range.
void add_gyroscope(DeviceModel& device, const GyroscopeOptions& options, std::uint64_t seed);

/// What the device would have written while a simulated scan was taken: its frames seen by accelerometer and
/// magnetometer, its distances, and the angular rate of the true motion, which starts and stops smoothly at
/// every node. Frames that are wrong in the scan (noise, outliers, disturbance) are wrong in the same way
/// here. With a gyroscope_rate there are rows of the gyroscope alone between those readings, also while the
/// device rests and while it is carried from the end of a curve to the start of the next, on no curve.
SensorLog simulate_log(const TracedNetwork& traced, const SimulatedScan& simulated, const DeviceModel& device,
                       std::uint64_t seed);

/// A recording for calibration: the device is turned slowly over all sides for a minute, at 25 readings per
/// second, with two seconds of rest at both ends. Readings lie on no curve.
SensorLog simulate_tumble(const DeviceModel& device, std::uint64_t seed);

}  // namespace batten
