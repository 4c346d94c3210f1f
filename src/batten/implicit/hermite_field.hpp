#pragma once
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// A smooth function of space: f(x) = Σ a_i φ(x − y_i) + Σ b_j · ∇_y φ(x − y_j) + c · x + d with φ(x) = |x|³.
/// Among all functions that have its values and slopes at the sites y, it is the one whose third derivatives
/// are least ([duchon1977], [macedo2011]).
class HermiteField {
 public:
  HermiteField() = default;
  /// @param sites m × 3. @param values m: a. @param slopes n × 3: b, at the first n sites, n ≤ m.
  /// @param affine c and d.
  HermiteField(const Points& sites, const Eigen::VectorXd& values, const Points& slopes,
               const Eigen::Vector4d& affine);

  /// f at a point. O(m).
  double value(const Eigen::Vector3d& x) const;
  /// f and its gradient.
  double value(const Eigen::Vector3d& x, Eigen::Vector3d& gradient) const;

 private:
  Eigen::ArrayX3d sites_, slopes_;  // by columns: sums run over the sites
  Eigen::ArrayXd values_;
  Eigen::Vector4d affine_ = Eigen::Vector4d::Zero();
};

/// What is asked of a field. The length of the scene should be about 1.
struct FieldConditions {
  Points sites;               ///< m × 3, no two at one place
  Eigen::VectorXd values;     ///< m: f there
  Eigen::VectorXd smoothing;  ///< m, at least 0: how dear a wrong value is; 0: values are met exactly
  /// n × 3 each, n ≤ m: unit vectors at the first n sites along which the slope of f is given. At a site on a
  /// curve of the surface they span the plane across it; along it the values speak for themselves.
  Points across, aside;

  /// The first problem found, naming field and row, or nothing.
  std::optional<std::string> problem() const;
};

/// The energy of fields as a function of their slopes at the sites: E(s) = sᵀ H s + 2 pᵀ s + constant, with
/// s_{2j} and s_{2j+1} the slopes along `across` and `aside` ([huang2019] with slopes in a plane in place of
/// gradients). Dense: O((m + 2 n)³) time, O((m + 2 n)²) memory.
class SlopeEnergy {
 public:
  /// @throws InvalidInput where conditions.problem() names one, SolverFailure for sites that lie at one
  /// place or in one plane; Cancelled.
  explicit SlopeEnergy(FieldConditions conditions, const Progress& progress = {});

  Eigen::Index n_slopes() const { return hessian_.rows(); }
  /// H, 2 n × 2 n, symmetric, positive definite.
  const Eigen::MatrixXd& hessian() const { return hessian_; }
  /// H⁻¹.
  const Eigen::MatrixXd& inverse() const { return inverse_; }
  /// p; zero where all values are.
  const Eigen::VectorXd& pull() const { return pull_; }
  /// The slopes that the values alone have, −H⁻¹ p.
  const Eigen::VectorXd& slopes_of_values() const { return free_slopes_; }
  /// The field of given slopes.
  HermiteField field(const Eigen::VectorXd& slopes) const;

 private:
  FieldConditions conditions_;
  Eigen::MatrixXd coupling_;       // A₁₁⁻¹ A₁₂: what values a unit of slope brings
  Eigen::VectorXd value_weights_;  // A₁₁⁻¹ of the values
  Eigen::MatrixXd hessian_, inverse_;
  Eigen::VectorXd pull_, free_slopes_;
};

}  // namespace batten
