#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/scan/samples.hpp"
#include "batten/scan/scan.hpp"

namespace batten {

/// How a gyroscope saw the device turn along a curve: frames up to one rotation, with the bias in them.
struct TurnPath {
  std::vector<Eigen::Matrix3d> frames;  ///< n, or empty without gyroscope
  Eigen::VectorXd times;                ///< n, seconds since the first reading
  std::vector<int> gaps;                ///< n, how many turns up to here are not known

  bool empty() const { return frames.empty(); }
};

/// Readings of one curve put in order: outliers removed, readings at one distance merged.
struct CleanCurve {
  Eigen::VectorXd distances;            ///< n, increasing, from 0
  std::vector<Eigen::Matrix3d> frames;  ///< n
  Eigen::VectorXd counts;               ///< n, readings merged into each
  std::vector<int> node_readings;       ///< indices into these arrays
  std::vector<int> node_ids;
  TurnPath turned;       ///< at the same places; of outliers as well
  int n_outliers = 0;    ///< readings removed
  int n_duplicates = 0;  ///< readings merged into others
};

/// Options of clean_readings().
struct CleanOptions {
  /// A reading whose quaternion has |q·q'| below this with both its neighbours is an outlier (S 3.5.3, with
  /// docs/errata.md#s-3-5-3; 0.9 is a turn of 51.7°), [0, 1]. 0 keeps all.
  double outlier_cosine = 0.9;
  /// Also remove short runs of such readings, and single ones that stand out of their surroundings by more
  /// than five standard deviations of the noise found in the scan (and 3°).
  bool robust = true;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Puts the readings of every curve in order. A scan whose outliers by the thesis's rule exceed a quarter of
/// a curve is taken as too sparse for that rule, and that curve is kept whole; `warnings` says so. Tangents
/// keep their direction, normals are made orthogonal to them.
/// @pre check_scan() has passed. @throws InvalidInput where a curve has no reading left; Cancelled.
std::vector<CleanCurve> clean_readings(const Scan& scan, const CleanOptions& options,
                                       std::vector<std::string>& warnings, const Progress& progress = {});

/// Standard deviation of one reading about its surroundings, per axis, in radians: from the spread of
/// readings at one distance and from the second differences along the curves, by the median, so that neither
/// outliers nor the shape nor slow drift count. 0 when no curve has three readings.
double reading_noise(const std::vector<CleanCurve>& curves);

/// Options of resample().
struct PrefilterOptions {
  /// Wanted distance between samples, in the unit of the scan; each segment between nodes takes the nearest
  /// step that divides it evenly (S 3.22 per segment). 0: the samples are the readings themselves.
  double step = 0;
  /// Radius of the Gaussian as a part of the step, S 3.5.3: 0.2 … 0.5; (0, 2].
  double sigma = 0.35;
  /// Fit frame and rate of turn in the window (local linear on SO(3)) instead of the plain average. Removes
  /// the bias at the ends of curves and between uneven readings; the thesis averages.
  bool local_linear = true;
  /// Let the window run on across the seam of closed curves.
  bool wrap = true;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Resamples cleaned curves. Nodes are samples. Where a step holds fewer readings than the window needs, the
/// window widens to the readings on both sides, so that no weight vanishes. @throws Cancelled.
SampledScan resample(const Scan& scan, const std::vector<CleanCurve>& curves, const PrefilterOptions& options,
                     const Progress& progress = {});

}  // namespace batten
