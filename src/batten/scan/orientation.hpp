#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/scan/calibration.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten {

/// Options of estimate_orientation() and of OrientationFilter. Deviations are standard deviations; densities
/// are per root hertz, so that they hold for every rate of readings.
struct OrientationOptions {
  Calibration calibration = {};
  /// Take north from the magnetometer. Without it the heading starts at 0 and drifts with what is left of the
  /// bias of the gyroscope.
  bool magnetometer = true;
  /// Deviation of the heading of the magnetometer, radians; above 0. Nothing: found from the readings by
  /// marginal likelihood (estimate_orientation()), or 0.07 (OrientationFilter).
  std::optional<double> heading_deviation = std::nullopt;
  /// Density of the gyroscope's noise, rad/s/√Hz; above 0. Larger than the noise of the sensor, for what the
  /// model does not know: larger values follow accelerometer and magnetometer more closely.
  double gyroscope_noise = 0.0015;
  double accelerometer_noise = 0.05;  ///< density, m/s²/√Hz; above 0
  double bias_deviation = 0.05;       ///< of the gyroscope's bias before any reading, rad/s; above 0
  /// How fast the device moves: deviation of its velocity per axis, m/s; above 0. It is what tells the
  /// acceleration of a motion from gravity. Larger values trust the accelerometer less.
  double speed = 0.5;
  /// How far it moves from the middle of its places: deviation per axis, metres; above 0.
  double reach = 0.5;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Orientations of a device over a recording, one per reading, and what was found on the way.
struct OrientationEstimate {
  /// n × 4, unit quaternions w, x, y, z with w ≥ 0: device → world, x north, y west, z up.
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> quaternions;
  Eigen::VectorXd tilt_deviation;     ///< n, radians: of the direction of gravity, per axis
  Eigen::VectorXd heading_deviation;  ///< n, radians; without magnetometer from the first reading on
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();            ///< rad/s, beside the calibration's
  Eigen::Vector3d gyroscope_bias_deviation = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();        ///< m/s², beside the calibration's
  Eigen::Matrix3d gyroscope_matrix = Eigen::Matrix3d::Zero();  ///< M: true rate = (I + M)(reading − bias)
  bool magnetometer_used = false;
  Eigen::Vector3d magnetometer_offset = Eigen::Vector3d::Zero();  ///< µT, beside the calibration's
  double field_strength = 0;          ///< of the undisturbed field, unit of the magnetometer
  double inclination = 0;             ///< of it below the horizon, radians
  double magnetometer_deviation = 0;  ///< of its heading, as used, radians
  double magnetometer_rejected = 0;   ///< share of its readings that got less than half of their weight
  double rms_turn = 0;                ///< residual of the gyroscope's turns, in standard deviations per axis
  double rms_velocity = 0;            ///< the same of the changes of velocity by the accelerometer
  double rms_heading = 0;             ///< the same of the headings of the magnetometer that were not rejected
  double rms_speed = 0;               ///< of the device, as estimated, m/s
  double moving = 0;                  ///< share of the time during which the device turned or was accelerated
  double longest_gap = 0;             ///< between readings of the gyroscope, seconds
  int iterations = 0;                 ///< Gauss–Newton steps; 0 of the causal filter
  bool converged = false;
  std::vector<std::string> warnings;
};

/// Orientations from gyroscope, accelerometer and magnetometer of a whole recording at once.
///
/// The most probable motion given all readings (docs/methods.md#orientation): turn, velocity and place of the
/// device at knots 50 ms apart, biases of gyroscope and accelerometer, scale and alignment of the gyroscope,
/// where the readings between the knots are summed up beforehand ([forster2017]). Velocity and place are
/// bounded, which takes the place of the usual assumption that accelerations are small or short. The
/// magnetometer gives the heading alone, robustly, its errors counted once per correlation time.
/// Gauss–Newton on a block tridiagonal system with a border: linear in the length of the recording, about
/// 0.2 s for a minute at 286 readings per second.
///
/// Distances, curves and nodes of the log are not looked at. Rows may lack any sensor: short gaps of
/// accelerometer and gyroscope are bridged, long ones are times of which nothing is known.
/// @throws InvalidInput without accelerometer or gyroscope, with fewer than two times, or naming the row
/// where the time falls; SolverFailure; Cancelled.
OrientationEstimate estimate_orientation(const SensorLog& log, const OrientationOptions& options = {},
                                         const Progress& progress = {});

/// The same by OrientationFilter: each row from the readings up to it alone, as a live view would show it.
OrientationEstimate filter_orientation(const SensorLog& log, const OrientationOptions& options = {},
                                       const Progress& progress = {});

}  // namespace batten
