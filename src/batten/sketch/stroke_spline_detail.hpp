#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

// Private to the room.
namespace batten::detail {

/// A place that a spline is to go by or through.
struct StrokeSample {
  double t;       ///< parameter, 0 to 1
  double weight;  ///< the share of the length that it stands for; 1 where it is held
  Eigen::Vector3d point;
};

/// A cubic spline over [0, 1], and what is added to it between held points.
struct StrokeSpline {
  int spans = 1;
  bool periodic = false;
  Points control;
  /// In order of t; `point` is what is missing there. From one to the next it changes without overshoot and
  /// with no slope at either end, so that it is never more than the larger of the two.
  std::vector<StrokeSample> offsets;

  /// The place at t in [0, 1].
  Eigen::Vector3d at(double t) const;
  /// What is added to the spline at t.
  Eigen::Vector3d offset_at(double t) const;
  /// The row of control point k.
  Eigen::Index index(int k) const { return periodic ? k % control.rows() : k; }
};

/// Least squares with equality constraints, solved with their multipliers. O((spans + held)³).
/// @param spans at least 1; of periodic splines at least 4.
/// @param bending weight of the second differences of control points beside all samples together.
/// @return control points that are not finite where the system has no solution.
StrokeSpline least_squares_spline(const std::vector<StrokeSample>& samples,
                                  const std::vector<StrokeSample>& held, int spans, bool periodic,
                                  double bending);

/// What a spline is asked for.
struct FitAims {
  double tolerance;  ///< root mean square distance from the samples
  double bending;    ///< see least_squares_spline()
  /// At most one span for every two samples or so: more would follow their noise and swing between them.
  bool noisy;
};

/// The spline with as few spans as follow the samples. Where held points are dense, they are samples like
/// the others, and what the spline then misses them by is added to it.
/// @param held in order of t; ends of open strokes among them.
StrokeSpline fitted_spline(const std::vector<StrokeSample>& samples, const std::vector<StrokeSample>& held,
                           bool periodic, const FitAims& aims);

/// n + 1 places at equal steps from t0 to t1; beyond 1 a periodic spline goes on from its beginning.
Points sampled(const StrokeSpline& spline, double t0, double t1, int n);

/// How often a part of a spline has to be sampled so that chords keep within 1e-5 of `length`: 16 to 1,000.
int samples_needed(const StrokeSpline& spline, double t0, double t1, double length);

}  // namespace batten::detail
