#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace batten {

/// The four cubic B-splines that are not zero at a parameter, of those over [0, spans] with knots at the
/// whole numbers.
struct CubicBasis {
  int first = 0;  ///< number of the first of the four
  std::array<double, 4> values{0, 0, 0, 0};
  std::array<double, 4> slopes{0, 0, 0, 0};  ///< derivatives by u
};

/// Evaluates the basis by the recurrence of Cox and de Boor.
/// @param u in [0, spans].
/// @param periodic uniform without end: basis k and basis k + spans are one, `spans` control points in all.
/// Otherwise clamped at the ends by repeated knots, with spans + 3 control points.
CubicBasis cubic_basis(double u, int spans, bool periodic);

/// A B-spline curve of any degree.
struct BSplineCurve {
  std::size_t degree = 0;
  std::vector<double> knots;               ///< not decreasing; as many as points + degree + 1
  std::vector<Eigen::RowVector3d> points;  ///< control points, more than `degree`

  /// De Boor's algorithm in the knot span `span`.
  /// @pre degree ≤ span < points.size(), knots[span] ≤ u ≤ knots[span + 1].
  Eigen::RowVector3d at(double u, std::size_t span) const;
};

}  // namespace batten
