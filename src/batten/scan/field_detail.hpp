#pragma once
#include <Eigen/Core>

namespace batten {

/// A magnetic field by the two figures that no turn of the device changes once up is known.
struct FieldFigures {
  double strength = 0;  ///< unit of the magnetometer
  double dip = 0;       ///< below the horizon, radians
};

/// @param field in the world, x and y of any heading.
FieldFigures field_figures(const Eigen::Vector3d& field);
/// How far a field is from the undisturbed one, squared, in deviations of 5 % of the strength and 4° of dip.
double field_distance(const FieldFigures& field, const FieldFigures& reference);
/// Weight of a residual of z standard deviations: 1/(1 + z²/4)², that of Geman and McClure's loss.
double robust_weight(double z_squared);
/// A magnetometer's errors come from its surroundings, so they stay for a while: one reading's worth of
/// information per so many seconds, however many there are.
constexpr double kFieldCorrelation = 0.3;
/// The same of velocity and place, which are bounded.
constexpr double kSpeedCorrelation = 0.5;
constexpr double kReachCorrelation = 1.0;
/// Prior deviation of the bias of the accelerometer, m/s².
constexpr double kForceBiasDeviation = 0.05;
/// Knots are this far apart, seconds: shorter steps changed nothing, far longer ones lose fast turns.
constexpr double kKnotInterval = 0.05;
/// Readings of a sensor that are farther apart than this, in seconds and in mean intervals, leave a gap.
constexpr double kLongestGap = 0.25;
constexpr double kLongestGapIntervals = 5;
/// What a device may do while nothing is known of it: densities of turn, rad/√s, and velocity, m/s/√s.
constexpr double kUnknownTurn = 2, kUnknownVelocity = 5;

}  // namespace batten
