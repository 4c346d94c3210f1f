#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

namespace batten {

/// Normal equations of a chain of K blocks of unknowns, each joined to the next, with q unknowns that all of
/// them share: block tridiagonal with a border. Factorised by block Cholesky and a Schur complement of the
/// border, in O(K). @tparam B unknowns of a block, the first three of them a turn.
template <int B>
class BorderedChain {
 public:
  static constexpr int kBlock = B;
  using Block = Eigen::Matrix<double, kBlock, kBlock>;
  using Vector = Eigen::Matrix<double, kBlock, 1>;
  template <int R>
  using Rows = Eigen::Matrix<double, R, kBlock>;

  BorderedChain(int n_blocks, int n_border);

  void clear();
  /// Adds JᵀJ and −Jᵀr of a residual of block k alone.
  template <int R>
  void add(int k, const Rows<R>& J, const Eigen::Matrix<double, R, 1>& r) {
    diagonal_[k].noalias() += J.transpose() * J;
    right_[k].noalias() -= J.transpose() * r;
  }
  /// Of blocks k and k + 1 and the border.
  template <int R>
  void add(int k, const Rows<R>& J, const Rows<R>& J_next,
           const Eigen::Matrix<double, R, Eigen::Dynamic>& J_border, const Eigen::Matrix<double, R, 1>& r) {
    this->template add<R>(k, J, r);
    this->template add<R>(k + 1, J_next, r);
    next_[k].noalias() += J_next.transpose() * J;
    border_[k].noalias() += J.transpose() * J_border;
    border_[k + 1].noalias() += J_next.transpose() * J_border;
    corner_.noalias() += J_border.transpose() * J_border;
    corner_right_.noalias() -= J_border.transpose() * r;
  }
  /// Adds a prior of weight w on unknown i of the border, whose value is x.
  void add_border(int i, double w, double x) {
    corner_(i, i) += w;
    corner_right_[i] -= w * x;
  }

  /// Factorises and solves. @return false where the matrix is not positive definite.
  bool solve();
  const Vector& step(int k) const { return step_[k]; }
  const Eigen::VectorXd& border_step() const { return border_step_; }

  /// The diagonal blocks of the inverse, turns alone (3 × 3 per block), and the border's.
  /// @pre solve() has succeeded.
  std::vector<Eigen::Matrix3d> turn_covariances() const;
  const Eigen::MatrixXd& border_covariance() const { return border_covariance_; }

 private:
  int n_, q_;
  std::vector<Block> diagonal_, next_;  ///< next_[k]: rows of k + 1, columns of k
  std::vector<Vector> right_;
  std::vector<Eigen::Matrix<double, kBlock, Eigen::Dynamic>> border_;
  Eigen::MatrixXd corner_;
  Eigen::VectorXd corner_right_;
  // After solve(): inverses of the pivots, and T⁻¹ times the border.
  std::vector<Block> pivot_inverse_;
  std::vector<Eigen::Matrix<double, kBlock, Eigen::Dynamic>> solved_;
  std::vector<Vector> step_;
  Eigen::VectorXd border_step_;
  Eigen::MatrixXd border_covariance_;
};

extern template class BorderedChain<3>;  ///< turns alone
extern template class BorderedChain<9>;  ///< turn, velocity, place

}  // namespace batten
