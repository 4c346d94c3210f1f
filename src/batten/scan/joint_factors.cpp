#include <algorithm>
#include <cmath>

#include "batten/scan/joint_model_detail.hpp"

// The factors of lengths in the joint estimate: one per curve, or a profile along each.
namespace batten {

double JointModel::chain_precision(int c) const {
  double length = 0;
  for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s) length += layout_.steps[s].length;
  const int n = layout_.first_knot[c + 1] - layout_.first_knot[c];
  return (n - 1) / (options_.speed_deviation * options_.speed_deviation * length);
}

/// The level of a curve is held at both ends, half as much at each, so that its direction does not count.
void JointModel::assemble_factors(const Weights& w) {
  using Eigen::Matrix3d;
  FrameLdlt& K = layout_.system;
  const auto right = [&](int knot) -> double& { return right_[3 * (layout_.scale_at + knot)]; };
  Matrix3d mean = Matrix3d::Zero(), first = Matrix3d::Zero(), own = -Matrix3d::Identity();
  own(0, 0) = -kMeanFactorVariance;
  K.add(layout_.mean_own, own);
  for (int c = 0; c < layout_.n_curves; ++c) {
    const int begin = layout_.first_knot[c], end = layout_.first_knot[c + 1];
    for (int k = begin; k < end; ++k) {
      const double e = state_.log_factors[k], used = layout_.knot_share[k] * std::exp(e);
      const double level = (k == begin ? 0.5 : 0) + (k + 1 == end ? 0.5 : 0);
      mean(0, 0) = used;
      K.add(layout_.mean_slot[k], mean);
      K.add(layout_.scale_slot[k], Eigen::Vector3d(level * w.scale, 1, 1).asDiagonal().toDenseMatrix());
      right(k) -= level * w.scale * e;
      right_[3 * layout_.mean_at] -= used - layout_.knot_share[k];
      if (k + 1 == end) continue;
      const double p = chain_precision(c), change = state_.log_factors[k + 1] - e;
      first(0, 0) = p;
      K.add(layout_.scale_slot[k], first);
      K.add(layout_.scale_slot[k + 1], first);
      K.add(layout_.next_scale_slot[k], -first);
      right(k) += p * change;
      right(k + 1) -= p * change;
    }
  }
}

void JointModel::draw_factors(const Weights& w, Random& random, Eigen::VectorXd& right) const {
  const auto at = [&](int knot) -> double& { return right[3 * (layout_.scale_at + knot)]; };
  for (int c = 0; c < layout_.n_curves; ++c) {
    const int begin = layout_.first_knot[c], last = layout_.first_knot[c + 1] - 1;
    for (const int end : {begin, last}) at(end) += std::sqrt(0.5 * w.scale) * random.normal();
    for (int k = begin; k < last; ++k) {
      const double noise = std::sqrt(chain_precision(c)) * random.normal();
      at(k) -= noise;
      at(k + 1) += noise;
    }
  }
  right[3 * layout_.mean_at] += std::sqrt(kMeanFactorVariance) * random.normal();
}

double JointModel::factor_energy(const Weights& w, const Eigen::VectorXd& delta, double& squares) const {
  const auto at = [&](int k) { return state_.log_factors[k] + delta[3 * (layout_.scale_at + k)]; };
  double sum = kMeanFactorVariance * delta.segment<3>(3 * layout_.mean_at).squaredNorm();
  squares = 0;
  for (int c = 0; c < layout_.n_curves; ++c) {
    const int begin = layout_.first_knot[c], last = layout_.first_knot[c + 1] - 1;
    squares += 0.5 * (at(begin) * at(begin) + at(last) * at(last));
    if (begin == last) {
      sum -= std::log(w.scale);
      continue;
    }
    const double p = chain_precision(c), hold = 0.5 * w.scale, n = last - begin;
    for (int k = begin; k < last; ++k) sum += p * (at(k + 1) - at(k)) * (at(k + 1) - at(k));
    // The determinant of a chain that is held at both ends.
    sum -= n * std::log(p) + std::log(2 * hold + hold * hold * n / p);
  }
  return sum + w.scale * squares;
}

Eigen::VectorXd JointModel::factor_deviation(const Progress& progress) {
  const int n = layout_.n_curves;
  progress.report("working", 0.5);
  // Per curve its mean log factor, as a row over all unknowns; and the mean of these.
  const auto row_of = [&](int c) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(3L * layout_.n_blocks);
    double share = 0;
    for (int k = layout_.first_knot[c]; k < layout_.first_knot[c + 1]; ++k) share += layout_.knot_share[k];
    for (int k = layout_.first_knot[c]; k < layout_.first_knot[c + 1]; ++k)
      row[3 * (layout_.scale_at + k)] = layout_.knot_share[k] / share;
    return row;
  };
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(3L * layout_.n_blocks);
  for (int c = 0; c < n; ++c) mean += row_of(c) / n;
  const Eigen::VectorXd with_mean = layout_.system.solve(mean);
  const double of_mean = mean.dot(with_mean);
  const bool profiles = layout_.n_knots() > n;
  if (!profiles) {
    std::vector<int> blocks(n);
    for (int c = 0; c < n; ++c) blocks[c] = layout_.scale_at + c;
    layout_.system.invert(blocks, progress);
  }
  Eigen::VectorXd deviations(n);
  for (int c = 0; c < n; ++c) {
    progress.report("working", 0.5);
    const Eigen::VectorXd row = row_of(c);
    const double own =
        profiles ? row.dot(layout_.system.solve(row)) : layout_.system.inverse(layout_.scale_slot[c])(0, 0);
    deviations[c] = std::sqrt(std::max(0.0, own - 2 * row.dot(with_mean) + of_mean));
  }
  return deviations;
}

}  // namespace batten
