#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// The cubic spline with continuous second derivatives through given values, by its second derivatives at the
/// knots: natural (none at the ends) or periodic.
class CubicSpline {
 public:
  /// @param knots n parameters, increasing, n at least 2 (periodic: 3).
  /// @param values n × 3; of a periodic spline the last row repeats the first.
  /// One sparse factorisation of n unknowns, diagonally dominant: O(n).
  CubicSpline(std::vector<double> knots, Points values, bool periodic);

  Eigen::Index n_pieces() const { return values_.rows() - 1; }
  /// The parameter that a piece takes, above 0.
  double width(Eigen::Index piece) const;
  const std::vector<double>& knots() const { return knots_; }
  const Points& values() const { return values_; }
  const Points& second_derivatives() const { return bends_; }

  /// At the share t in [0, 1] of a piece; the derivative is by the parameter.
  Eigen::Vector3d at(Eigen::Index piece, double t) const;
  Eigen::Vector3d derivative(Eigen::Index piece, double t) const;
  /// Arc length of the first part of a piece, up to t: Gauss's rule on two halves, for the speed of a cubic
  /// is the root of a quartic.
  double length(Eigen::Index piece, double t = 1) const;
  /// d(arc length)/dt.
  double speed(Eigen::Index piece, double t) const { return derivative(piece, t).norm() * width(piece); }

 private:
  std::vector<double> knots_;
  Points values_, bends_;
};

}  // namespace batten
