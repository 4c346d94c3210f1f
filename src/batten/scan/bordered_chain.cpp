#include <cmath>

#include <Eigen/Cholesky>

#include "batten/scan/bordered_chain_detail.hpp"

namespace batten {

template <int B>
BorderedChain<B>::BorderedChain(int n_blocks, int n_border) : n_(n_blocks), q_(n_border) {
  const auto n = static_cast<size_t>(n_);
  diagonal_.resize(n);
  next_.resize(n);
  right_.resize(n);
  border_.resize(n);
  clear();
}

template <int B>
void BorderedChain<B>::clear() {
  for (size_t k = 0; k < diagonal_.size(); ++k) {
    diagonal_[k].setZero();
    next_[k].setZero();
    right_[k].setZero();
    border_[k].setZero(kBlock, q_);
  }
  corner_.setZero(q_, q_);
  corner_right_.setZero(q_);
}

template <int B>
bool BorderedChain<B>::solve() {
  // Forward: A_k ← A_k − C A_{k−1}⁻¹ Cᵀ, and the right sides (border and residual together).
  const auto n = static_cast<size_t>(n_);
  pivot_inverse_.resize(n);
  solved_.resize(n);
  step_.resize(n);
  Block carried = Block::Zero();
  Eigen::MatrixXd right(kBlock, q_ + 1);
  std::vector<Eigen::Matrix<double, kBlock, Eigen::Dynamic>> reduced(n);
  for (size_t k = 0; k < n; ++k) {
    const Block A = diagonal_[k] - carried;
    right << border_[k], right_[k];
    if (k > 0) right.noalias() -= next_[k - 1] * (pivot_inverse_[k - 1] * reduced[k - 1]);
    reduced[k] = right;
    const Eigen::LLT<Block> factor(A);
    if (factor.info() != Eigen::Success) return false;
    pivot_inverse_[k] = factor.solve(Block::Identity());
    if (!pivot_inverse_[k].allFinite()) return false;
    if (k + 1 < n) carried.noalias() = next_[k] * pivot_inverse_[k] * next_[k].transpose();
  }
  // Backward: T⁻¹ [B r].
  for (size_t k = n; k-- > 0;) {
    right = reduced[k];
    if (k + 1 < n) right.noalias() -= next_[k].transpose() * solved_[k + 1];
    solved_[k] = pivot_inverse_[k] * right;
  }
  Eigen::MatrixXd schur = corner_;
  Eigen::VectorXd rest = corner_right_;
  for (size_t k = 0; k < n; ++k) {
    schur.noalias() -= border_[k].transpose() * solved_[k].leftCols(q_);
    rest.noalias() -= border_[k].transpose() * solved_[k].col(q_);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(schur);
  if (factor.info() != Eigen::Success) return false;
  border_covariance_ = factor.solve(Eigen::MatrixXd::Identity(q_, q_));
  border_step_ = factor.solve(rest);
  for (size_t k = 0; k < n; ++k) step_[k] = solved_[k].col(q_) - solved_[k].leftCols(q_) * border_step_;
  return border_step_.allFinite();
}

template <int B>
std::vector<Eigen::Matrix3d> BorderedChain<B>::turn_covariances() const {
  const auto n = static_cast<size_t>(n_);
  std::vector<Eigen::Matrix3d> covariances(n);
  Block P;
  for (size_t k = n; k-- > 0;) {
    if (k + 1 == n) {
      P = pivot_inverse_[k];
    } else {
      const Block G = pivot_inverse_[k] * next_[k].transpose();
      P = pivot_inverse_[k] + G * P * G.transpose();
    }
    const Eigen::Matrix<double, 3, Eigen::Dynamic> W = solved_[k].template topRows<3>().leftCols(q_);
    covariances[k] = P.template topLeftCorner<3, 3>() + W * border_covariance_ * W.transpose();
  }
  return covariances;
}

template class BorderedChain<3>;
template class BorderedChain<9>;

}  // namespace batten
