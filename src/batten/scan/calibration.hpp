#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// What to do with a raw three-axis reading: calibrated = matrix · (raw − offset), in the unit of the sensor.
struct SensorCalibration {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();      ///< hard iron, zero error
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  ///< scale and soft iron; determinant 1

  Eigen::Vector3d apply(const Eigen::Vector3d& raw) const { return matrix * (raw - offset); }
};

/// The calibration of a device.
struct Calibration {
  SensorCalibration accelerometer;
  SensorCalibration magnetometer;
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();  ///< rad/s, subtracted
};

/// How well a sensor was calibrated.
struct EllipsoidFitReport {
  long readings = 0;
  long outliers = 0;        ///< readings that got no weight
  double radius = 0;        ///< mean length of the calibrated readings: g, or the strength of the field
  double rms_residual = 0;  ///< of the length of the calibrated readings, without outliers, divided by radius
  double rms_before = 0;    ///< the same of the raw readings about their mean length
  double coverage = 0;      ///< share of 32 evenly spread directions that have a reading within 20 degrees
  double uncertainty = 0;   ///< largest standard deviation of the offset in any direction, divided by radius
  int iterations = 0;
};

/// Options of fit_ellipsoid().
struct EllipsoidFitOptions {
  /// Least coverage, [0, 1]; below, the fit is refused. A slow tumble over all sides reaches 0.9 and more.
  double smallest_coverage = 0.5;
  /// Largest uncertainty of the offset, in radii, > 0; above, the fit is refused.
  double largest_uncertainty = 0.02;
  int max_iterations = 200;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Fits the ellipsoid on which the raw readings of a field of constant strength lie (n × 3), by
/// Levenberg–Marquardt on the lengths ‖M (x − o)‖ − 1 with a symmetric M and Tukey's biweight, so that
/// readings far off (knocks, passing iron) have no say.
///
/// The symmetric matrix leaves a rotation open, which no single sensor can show; align_magnetometer() finds
/// it. Rows that are not finite are left out.
/// @throws InvalidInput in words: too few readings, directions not covered and which, or no ellipsoid.
SensorCalibration fit_ellipsoid(const Points& readings, EllipsoidFitReport& report,
                                const EllipsoidFitOptions& options = {});

/// The rotation of the magnetometer against the accelerometer: both calibrated readings keep a constant angle
/// (90° + inclination) in every orientation. Changes calibration.magnetometer.matrix to R · matrix.
/// @return the angle of the rotation found, radians; 0 where the readings do not determine it (nothing is
/// changed then).
double align_magnetometer(const Points& accelerometer, const Points& magnetometer, Calibration& calibration);

/// A device calibrated from one tumbling recording.
struct DeviceCalibration {
  Calibration calibration;
  EllipsoidFitReport accelerometer;
  EllipsoidFitReport magnetometer;
  double alignment = 0;        ///< radians, see align_magnetometer()
  double inclination = 0;      ///< of the field in the recording, radians below the horizon
  long gyroscope_windows = 0;  ///< of 20 readings at rest that the bias is the mean of; 0: no bias
  std::vector<std::string> warnings;
};

struct SensorLog;

/// Calibrates accelerometer, magnetometer and gyroscope bias. A device without one of the first two is
/// refused.
/// @throws InvalidInput as fit_ellipsoid(), with the name of the sensor.
DeviceCalibration calibrate_device(const SensorLog& tumble, const EllipsoidFitOptions& options = {});

}  // namespace batten
