#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// The clamped C² cubic spline through given points as it depends on its end tangents a and b (derivatives by
/// the parameter). Its bending energy ∫|x''|² is quadratic in them; with x'' at the ends its gradient is
/// ∂E/∂a = −2 x''(0), ∂E/∂b = +2 x''(L), which for uniform knots is S (C.19).
///
/// Set-up and tangents() take O(n). Source: S appendix C, solved by ratios that stay between 0 and 1 whatever
/// n is (the c_k of (C.15) overflow).
class ClampedSpline {
 public:
  /// @param points n × 3, n at least 2; kept by reference: they must outlive the spline.
  /// @param knots n parameters, increasing.
  ClampedSpline(const Points& points, const Eigen::VectorXd& knots);

  /// E(a, b) = aa |a|² + 2 ab a·b + bb |b|² − 2 pull_a·a − 2 pull_b·b + constant
  double aa() const { return energy_aa_; }
  double ab() const { return energy_ab_; }
  double bb() const { return energy_bb_; }
  Eigen::Vector3d pull_a() const { return pull_a_; }
  Eigen::Vector3d pull_b() const { return pull_b_; }

  /// The tangents at all points, n × 3, for tangents a and b at the ends: with them the pieces (HermiteCubic)
  /// meet with equal second derivatives.
  Points tangents(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

 private:
  struct Affine {
    Eigen::RowVector3d constant;
    double a, b;
  };
  const Points& points_;
  Eigen::VectorXd h_, ratio_, from_a_;
  Points slopes_, data_;
  Affine first_, last_;
  double energy_aa_ = 0, energy_ab_ = 0, energy_bb_ = 0;
  Eigen::Vector3d pull_a_, pull_b_;
};

}  // namespace batten
