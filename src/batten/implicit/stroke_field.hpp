#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/stage_times.hpp"
#include "batten/implicit/hermite_field.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {

/// Strokes as points at even distances, with their directions.
struct StrokeSamples {
  Points positions;  ///< n × 3, in the unit of the strokes
  /// n × 3 unit directions, zero at corners and ends, where a stroke has none.
  Points directions;
  std::vector<int> stroke;  ///< the curve that each lies on
};

/// Samples every stroke evenly; strokes shorter than `step` give their ends, those without length (a tap)
/// nothing.
/// @param step in the unit of the strokes, above 0.
StrokeSamples stroke_samples(const CurveNetwork& strokes, double step);

/// As many of the points as asked for, each as far from those before it as can be; the first is row 0.
/// O(n · count). @param least stops when no point is farther than this from those taken.
std::vector<int> farthest_points(const Points& points, int count, double least);

/// Options of stroke_field().
struct StrokeFieldOptions {
  /// The surface closes around the strokes: outside their hull the field is the distance from it. Else the
  /// strokes alone decide, and the surface goes on beyond them.
  bool closed = true;
  /// Places on strokes where normals are found, at least 8: time goes with the cube, 1 s for 400.
  int most_sites = 500;
  /// Strokes that miss each other are met halfway: weight of FieldConditions::smoothing, at least 0. Normals
  /// are searched with this one, which should be generous: the less it is, the more valleys there are to be
  /// caught in. Where the strokes are then missed by more than kNearMiss, it is lessened in steps, with the
  /// normals that were found as a start, as long as the misses shrink and the surface gets no handles.
  double smoothing = 1e-4;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Misses that are left alone: 95th percentile ÷ diameter.
constexpr double kNearMiss = 0.003;

/// A function of space that vanishes on strokes.
class StrokeField {
 public:
  StrokeField() = default;
  StrokeField(HermiteField field, const Eigen::Vector3d& middle, double diameter)
      : field_(std::move(field)), middle_(middle), diameter_(diameter) {}

  /// f, nearly the distance in the unit of the strokes near them, negative inside.
  double value(const Eigen::Vector3d& x) const { return diameter_ * field_.value((x - middle_) / diameter_); }
  /// The same and its gradient.
  double value(const Eigen::Vector3d& x, Eigen::Vector3d& gradient) const {
    return diameter_ * field_.value((x - middle_) / diameter_, gradient);
  }
  double diameter() const { return diameter_; }

 private:
  HermiteField field_;  // in diameters from the middle
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double diameter_ = 1;
};

/// The field through strokes and how well it meets them.
struct StrokeFieldResult {
  StrokeField field;
  int n_sites = 0;
  int n_cuts = 0;        ///< handles that no stroke asked for and that were taken away
  double smoothing = 0;  ///< the one that was used
  double energy = 0;
  /// How far the samples of the strokes are from f = 0, |f|/|∇f| ÷ diameter: 95th percentile and largest.
  double misfit_p95 = 0, misfit_max = 0;
  StageTimes times;
};

/// The smoothest field through strokes that have no normals: unit normals perpendicular to the strokes are
/// found at sites spread over them, so that the field that has them varies least (find_slopes()). Handles of
/// a closed surface are taken away, the smallest first (essential_loops()), where the strokes are met as well
/// by a field that varies hardly more.
/// @throws InvalidInput where options.problem() names one, for strokes without extent, in a plane, or with
/// fewer than 8 places that have a direction; SolverFailure; Cancelled.
StrokeFieldResult stroke_field(const StrokeSamples& samples, const StrokeFieldOptions& options = {},
                               const Progress& progress = {});

}  // namespace batten
