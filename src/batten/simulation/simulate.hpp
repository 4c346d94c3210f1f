#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "batten/scan/scan.hpp"
#include "batten/simulation/traced_curve.hpp"

namespace batten {

/// What a simulated device does wrong. All zero: exact data. Each effect draws from its own stream of random
/// numbers, so that switching one on leaves the others as they were.
struct SimulateOptions {
  std::uint64_t seed = 0;
  /// Mean distance between readings in diameters; above 0.
  double step = 0.006;
  /// Largest shift of a reading along the curve, as a fraction of the step, uniform; [0, 0.5).
  double jitter = 0.35;
  /// Readings at every node, where the device rests; at least 1.
  int dwell = 3;
  /// White noise of the frames: standard deviation per axis, radians, independent per reading.
  double orientation_noise = 0;
  /// Slow drift of the frames: AR(1) with this standard deviation per axis, radians.
  double drift = 0;
  /// Distance along the curve over which the drift forgets itself (to 1/e), in diameters; above 0.
  double drift_length = 0.15;
  /// All distances of a curve are multiplied by 1 + N(0, this).
  double odometer_error = 0;
  /// All distances of a curve are multiplied by 1 + U(−this, this); [0, 1).
  double curve_length_error = 0;
  /// Distances come from time stamps, and the hand goes up to this part slower and faster along each curve,
  /// smoothly, in about three waves at most; times are scaled to the length of the curve. [0, 0.9].
  double speed_variation = 0;
  /// The fraction of readings that get a random orientation; [0, 1].
  double outliers = 0;
  /// A magnetic disturbance turns the heading of one curve about the vertical by up to this angle, radians,
  /// as a smooth bump over `disturbance_extent` of its length.
  double disturbance = 0;
  double disturbance_extent = 0.1;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What was drawn: the figures of a simulated scan, per reading or per curve.
struct SimulateReport {
  double rms_orientation_noise = 0;      ///< of the white part, per axis, radians
  double rms_drift = 0;                  ///< per axis, radians
  std::vector<double> distance_factors;  ///< per curve: odometer and length error together
  long n_outliers = 0;
  int disturbed_curve = -1;     ///< −1 without disturbance
  double disturbed_centre = 0;  ///< distance along that curve where the bump is highest
};

/// A simulated scan with its truth.
struct SimulatedScan {
  Scan scan;
  /// Per curve, the true distances of the readings along it (n): where each of them was really taken.
  std::vector<Eigen::VectorXd> true_distances;
  /// Per curve, the true frames [t N B] of the readings.
  std::vector<std::vector<Eigen::Matrix3d>> true_frames;
  SimulateReport report;
};

/// Moves a simulated device along the curves.
///
/// Frames are multiplied from the left by exp(white + drift); the disturbance turns the true frame first, an
/// outlier replaces the result. Distances are multiplied by one factor per curve.
/// @throws InvalidInput when an option is out of range or the object has no curves.
SimulatedScan simulate_scan(const TracedNetwork& traced, const SimulateOptions& options = {});

}  // namespace batten
