#pragma once
#include <Eigen/Core>

#include "batten/curves/gauss.hpp"

namespace batten {

/// A cubic over a piece of parameter, by its ends and its derivatives there. Evaluated at t in [0, 1], the
/// share of the piece; derivatives are by the parameter, which advances by `width` over the piece.
struct HermiteCubic {
  double width;  ///< of the piece, positive
  Eigen::RowVector3d begin, end;
  Eigen::RowVector3d begin_slope, end_slope;  ///< derivatives by the parameter

  /// The point.
  Eigen::RowVector3d at(double t) const {
    const double t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * begin + width * (t3 - 2 * t2 + t) * begin_slope + (3 * t2 - 2 * t3) * end +
           width * (t3 - t2) * end_slope;
  }
  /// The first derivative by the parameter.
  Eigen::RowVector3d derivative(double t) const {
    const double t2 = t * t;
    return (6 * t2 - 6 * t) / width * (begin - end) + (3 * t2 - 4 * t + 1) * begin_slope +
           (3 * t2 - 2 * t) * end_slope;
  }
  /// The second derivative by the parameter.
  Eigen::RowVector3d second_derivative(double t) const {
    return (12 * t - 6) / (width * width) * (begin - end) + (6 * t - 4) / width * begin_slope +
           (6 * t - 2) / width * end_slope;
  }
  /// Arc length of the whole, by gauss_integral().
  double length() const {
    return width *
           gauss_integral([this](double t) { return derivative(t).norm(); }, kGaussRuleOfFifteenDigits);
  }
};

}  // namespace batten
