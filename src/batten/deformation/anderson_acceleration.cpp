#include <Eigen/Dense>

#include "batten/deformation/anderson_acceleration_detail.hpp"

namespace batten::detail {

void AndersonAcceleration::advance(Points& x, const Points& g, double damping) {
  const Points residual = g - x;
  if (!past_.empty()) {
    past_.back().x = x - past_.back().x;
    past_.back().residual = residual - past_.back().residual;
  }
  const auto m = static_cast<Eigen::Index>(past_.size());
  Points step = damping * residual;
  if (m > 0) {
    Eigen::MatrixXd gram(m, m);
    Eigen::VectorXd right(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j)
        gram(i, j) = gram(j, i) = past_[i].residual.cwiseProduct(past_[j].residual).sum();
      right[i] = past_[i].residual.cwiseProduct(residual).sum();
    }
    // Steps that have become parallel must not blow up the combination.
    gram.diagonal().array() *= 1 + 1e-10;
    const Eigen::VectorXd share = gram.ldlt().solve(right);
    if (share.allFinite())
      for (Eigen::Index i = 0; i < m; ++i) step -= share[i] * (past_[i].x + damping * past_[i].residual);
  }
  if (m == depth_) past_.erase(past_.begin());
  past_.push_back({x, residual});
  x += step;
}

}  // namespace batten::detail
