#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "batten/core/arrays.hpp"
#include "batten/rotation/wahba.hpp"
#include "batten/scan/calibration.hpp"
#include "batten/scan/scan.hpp"

namespace batten {

/// How the device sits on the curve: the directions of its own axes.
struct DeviceAxes {
  Eigen::Vector3d forward{1, 0, 0};  ///< of travel, in device axes; unit
  Eigen::Vector3d normal{0, 0, 1};   ///< away from the surface, in device axes; unit, at right angles

  /// The rotation whose columns are forward, normal, forward × normal in device axes: it maps coordinates in
  /// the Darboux frame to device coordinates (docs/methods.md#conventions).
  Eigen::Matrix3d matrix() const;
};

/// A curve of a log, as its `# curve` line tells.
struct LogCurve {
  int number = 0;  ///< as in the file
  bool boundary = false;
  bool closed = false;
  std::string name;
  bool sharp = false;  ///< an edge of the surface, see NetworkCurve::sharp
};

/// Raw readings of a device, row by row as they were recorded. What a device does not measure is NaN.
struct SensorLog {
  static constexpr int kNone = -1;  ///< no curve, no node

  DeviceAxes axes;
  std::vector<LogCurve> curves;
  Eigen::VectorXd time;      ///< n, seconds
  std::vector<int> curve;    ///< n, indices into `curves`; kNone between curves
  std::vector<int> node;     ///< n, node numbers; kNone away from nodes
  Eigen::VectorXd distance;  ///< n, metres along the curve
  Points accelerometer;      ///< n × 3, specific force in device axes, m/s²: at rest it points up, 9.81
  Points magnetometer;       ///< n × 3, magnetic field in device axes, µT
  Points gyroscope;          ///< n × 3, angular rate in device axes, rad/s

  Eigen::Index n_readings() const { return time.size(); }
  /// Gives every column n rows; new values are NaN or kNone.
  void resize(Eigen::Index n);
};

/// How readings become orientations.
struct LogScanOptions {
  Calibration calibration;
  /// Inclination of the magnetic field below the horizon, radians; nothing: estimated from the readings.
  std::optional<double> inclination;
  /// Weights α of (3.1), > 0. Lower the second where iron is near.
  double accelerometer_weight = 1;
  double magnetometer_weight = 1;
  WahbaMethod method = WahbaMethod::Quaternion;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A scan from raw readings, and how it came about.
struct LogScan {
  Scan scan;
  /// Per curve, per reading: the rotation vector from the reading before in the axes of the Darboux frame,
  /// X_i = X_{i−1} exp(g_i), integrated from the gyroscope; NaN where there is none, and at the first
  /// reading.
  std::vector<Points> gyroscope_turns;
  double inclination = 0;  ///< used, radians
  bool inclination_estimated = false;
  bool times_for_distances = false;  ///< the log has no distances: seconds of motion stand in for them
  std::vector<std::string> warnings;
};

/// Orientations by Wahba's problem for every reading that lies on a curve and has both vectors (S 3.4.2),
/// with references up = (0, 0, 1) and field = (cos I, 0, −sin I).
/// @throws InvalidInput naming curve and reading when the log has no curves, no magnetometer or no
/// accelerometer, when all readings of a node are incomplete, or as check_scan().
LogScan scan_from_log(const SensorLog& log, const LogScanOptions& options = {});

}  // namespace batten
