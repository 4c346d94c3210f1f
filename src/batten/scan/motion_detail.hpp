#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// What is wrong with a gyroscope and an accelerometer, the same for a whole recording:
/// true rate = (I + M)(reading − b), true specific force = reading − b_a.
struct InertialErrors {
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();      ///< b, rad/s
  Eigen::Matrix3d gyroscope_matrix = Eigen::Matrix3d::Zero();    ///< M: scale, misalignment
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< b_a, m/s²

  /// All of them in the order of the places below, M column by column.
  Eigen::Matrix<double, 15, 1> vector() const;
  static constexpr int kBias = 0, kMatrix = 3, kForce = 12, kCount = 15;  ///< places in derivatives
};

/// How a device moves in a time T by its gyroscope and accelerometer, in its axes at the start
/// ([forster2017]): the turn R, and velocity and place that the specific force alone gives, together with
/// their derivatives by InertialErrors: R exp(R_by dε), v + v_by dε, p + p_by dε.
struct Motion {
  using Derivative = Eigen::Matrix<double, 3, InertialErrors::kCount>;

  double time = 0;  ///< T, seconds
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), p = Eigen::Vector3d::Zero();  ///< m/s, m
  Derivative R_by = Derivative::Zero(), v_by = Derivative::Zero(), p_by = Derivative::Zero();
  double turned = 0;        ///< ∫|ω|, radians: errors of the scale grow with it
  bool turn_known = true;   ///< the gyroscope was read all the time
  bool force_known = true;  ///< and the accelerometer

  /// The same for other errors, to first order in their difference.
  Motion corrected(const Eigen::Matrix<double, InertialErrors::kCount, 1>& difference) const;
  /// Appends a time without readings.
  void append_gap(double dt);
  /// The same with the gyroscope alone: velocity and place go on without force.
  void append_turn(double dt, const Eigen::Vector3d& rate_before, const Eigen::Vector3d& rate_after,
                   const InertialErrors& errors);
  /// Appends dt between two readings of both sensors (trapezoidal rule), O(1).
  void append(double dt, const Eigen::Vector3d& rate_before, const Eigen::Vector3d& rate_after,
              const Eigen::Vector3d& force_before, const Eigen::Vector3d& force_after,
              const InertialErrors& errors);
};

/// Readings of a sensor with short gaps filled in.
struct SensorStream {
  Points values;            ///< n × 3, linear in time where the file has none
  std::vector<char> known;  ///< per row; 0 where the nearest readings are too far away
};
/// @param longest_gap between two readings that are joined by a straight line, seconds.
SensorStream filled_stream(const Points& readings, const Eigen::VectorXd& time, double longest_gap);

}  // namespace batten
