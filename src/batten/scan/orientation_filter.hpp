#pragma once
#include <limits>
#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "batten/scan/orientation.hpp"

namespace batten {

/// One reading of a device. What was not measured is NaN.
struct InertialReading {
  static constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

  double time = 0;                                                      ///< seconds, not decreasing
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Constant(kMissing);  ///< specific force, device axes, m/s²
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Constant(kMissing);      ///< rad/s
  Eigen::Vector3d magnetometer = Eigen::Vector3d::Constant(kMissing);   ///< µT
};

/// Orientation while a recording goes on: the causal counterpart of estimate_orientation(), with the same
/// model in an error-state Kalman filter of 12 unknowns (turn, velocity, both biases). O(1) per reading,
/// some microseconds; nothing grows.
class OrientationFilter {
 public:
  /// @throws InvalidInput on bad options.
  explicit OrientationFilter(const OrientationOptions& options = {});
  ~OrientationFilter();
  OrientationFilter(OrientationFilter&&) noexcept;
  OrientationFilter& operator=(OrientationFilter&&) noexcept;

  /// Takes the next reading. @return the orientation (device → world: x north, y west, z up) at its time;
  /// nothing before the first reading of the accelerometer.
  /// @throws InvalidInput where the time falls.
  std::optional<Eigen::Quaterniond> add(const InertialReading& reading);

  double tilt_deviation() const;                     ///< radians, per axis, at the last reading
  double heading_deviation() const;                  ///< radians
  Eigen::Vector3d gyroscope_bias() const;            ///< rad/s, beside the calibration's
  Eigen::Vector3d gyroscope_bias_deviation() const;  ///< rad/s
  Eigen::Vector3d accelerometer_bias() const;        ///< m/s², beside the calibration's
  double field_strength() const;                     ///< of the undisturbed field; 0 while unknown
  double inclination() const;                        ///< of it below the horizon, radians
  double magnetometer_rejected() const;              ///< share of its readings so far
  bool has_heading() const;                          ///< the magnetometer has been read

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace batten
