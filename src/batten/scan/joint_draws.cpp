#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "batten/core/parallel.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/joint_model_detail.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

}  // namespace

// With residuals r(x) = W^(-1/2) ε instead of those of the data, the least-squares solution H⁻¹ Jᵀ W^(1/2) ε
// has the covariance H⁻¹ Jᵀ W J H⁻¹ = H⁻¹. The rows of multipliers take the noise of what they bind as it is.

void JointModel::draw_curve(int c, const Weights& w, Random& random, Eigen::VectorXd& right) const {
  const auto at = [&](int block) { return right.segment<3>(3 * block); };
  for (int i = layout_.first_sample[c]; i < layout_.first_sample[c + 1]; ++i) {
    const Datum& d = data_[i];
    if (!(d.readings > 0)) continue;
    const Vector3d noise = std::sqrt(w.white * d.readings) * random.normal3();
    at(layout_.frame_of_sample[i]) += d.J.transpose() * noise;
    at(layout_.drift_at + i) += noise;
  }
  at(layout_.drift_at + layout_.first_sample[c]) += std::sqrt(w.drift) * random.normal3();
  for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s) {
    const int i = layout_.drift_at + layout_.steps[s].sample_before;
    const Vector3d noise = std::sqrt(w.drift_precision[s]) * random.normal3();
    at(i + 1) += noise;
    at(i) -= w.drift_decay[s] * noise;
  }
  for (int i = layout_.first_segment[c]; i < layout_.first_segment[c + 1]; ++i) {
    const JointSegment& segment = layout_.segments[i];
    at(segment.multiplier) += kSlip * std::sqrt(segment.length) * random.normal3();
  }
}

/// Rates of turn: their prior precision P joins neighbouring steps, so that its root takes the place of the
/// weights.
void JointModel::draw_shape(Random& random, Eigen::VectorXd& right) const {
  const auto n = static_cast<Eigen::Index>(layout_.steps.size());
  Eigen::MatrixXd noise(n, 3);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd z(n);
    for (Eigen::Index s = 0; s < n; ++s) z[s] = random.normal();
    noise.col(axis) = layout_.shape.root_times(z);
  }
  for (Eigen::Index s = 0; s < n; ++s) {
    const JointStep& step = layout_.steps[static_cast<size_t>(s)];
    const Vector3d force = omega_by_[static_cast<size_t>(s)].transpose() * noise.row(s).transpose();
    right.segment<3>(3 * step.after) += force;
    right.segment<3>(3 * step.before) -= force;
  }
}

double JointModel::mean_factor_variance(double scale) const {
  double length = 0, squares = 0;
  for (int c = 0; c < layout_.n_curves; ++c) {
    double of_curve = 0;
    for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s)
      of_curve += layout_.steps[s].length;
    length += of_curve;
    squares += of_curve * of_curve;
  }
  return scale * scale * squares / (length * length);
}

Eigen::VectorXd JointModel::draw(const NoiseModel& noise, Random& random) const {
  const Weights w = weights_of_noise(noise);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(3L * layout_.n_blocks);
  const auto at = [&](int block) { return right.segment<3>(3 * block); };
  for (int c = 0; c < layout_.n_curves; ++c) draw_curve(c, w, random, right);
  draw_shape(random, right);
  for (const auto& [f, g] : layout_.normals) {
    const Vector3d push = std::sqrt(normal_precision_) * random.normal3();
    at(f) += hat(state_.X[f].col(1)) * push;
    at(g) -= hat(state_.X[g].col(1)) * push;
  }
  draw_factors(w, random, right);
  turns_.draw(random, right);
  Eigen::VectorXd deviation = layout_.system.solve(right);
  // The estimate holds the mean factor, which no data tell: it is as unsure as the mean of the odometer's.
  const double common = std::sqrt(mean_factor_variance(noise.scale)) * random.normal();
  for (int k = 0; k < layout_.n_knots(); ++k) deviation[3 * (layout_.scale_at + k)] += common;
  for (int v = 0; v < layout_.n_nodes; ++v)
    deviation.segment<3>(3 * (layout_.node_at + v)) += common * state_.nodes.row(v).transpose();
  return deviation;
}

namespace {

/// Of their own, so that they are the same whatever was drawn before.
constexpr std::uint64_t kDrawSeed = 0x756e6365727461;
/// Deviations of the factors that are tried, from the one found: factors 2^(k/2).
constexpr int kLeastScale = -4, kMostScale = 8;
/// Added to the square of the prior of the search: two thirds of all odometers are then thought to lie within
/// a factor of two of the centre, not three. Wider, few curves would leave too much open.
constexpr double kPriorWeight = 1.5;

/// The noise with the deviation of the factors that is to be expected instead of the most likely one: few
/// curves say little of it, and the most likely one is then far too small. That the mean factor is held at 1
/// is no evidence for small ones: the density of that is taken off.
NoiseModel expected_noise(JointModel& model, NoiseModel noise, const Progress& progress) {
  const NoisePrior& prior = model.prior();
  const double low = prior.at(prior.low()).scale, high = prior.at(prior.high()).scale;
  std::vector<double> scales, evidence;
  for (int k = kLeastScale; k <= kMostScale; ++k) {
    NoiseModel other = noise;
    other.scale *= std::pow(2, 0.5 * k);
    if (k != 0 && !(other.scale >= low && other.scale <= high)) continue;
    scales.push_back(other.scale);
    const double u = prior.coordinates(other)[NoisePrior::kScale];
    evidence.push_back(model.evaluate(other, false, progress).evidence + kPriorWeight * u * u -
                       std::log(model.mean_factor_variance(other.scale) + kMeanFactorVariance));
  }
  const double best = *std::min_element(evidence.begin(), evidence.end());
  double sum = 0, mean = 0;
  for (size_t i = 0; i < scales.size(); ++i) {
    const double density = std::exp(0.5 * (best - evidence[i]));
    sum += density;
    mean += density * scales[i];
  }
  noise.scale = mean / sum;
  return noise;
}

JointDraw joint_draw(const JointModel& model, const Eigen::VectorXd& deviation) {
  const JointLayout& layout = model.layout();
  JointDraw draw;
  const auto factor_at = [&](int knot) { return deviation[3 * (layout.scale_at + knot)]; };
  for (int c = 0; c < layout.n_curves; ++c) {
    const int first = layout.first_sample[c], n = layout.first_sample[c + 1] - first;
    Points turns(n, 3);
    for (int k = 0; k < n; ++k)
      turns.row(k) = deviation.segment<3>(3 * layout.frame_of_sample[first + k]).transpose();
    draw.turns.push_back(std::move(turns));
    Eigen::VectorXd factors(layout.first_step[c + 1] - layout.first_step[c]);
    for (Eigen::Index s = 0; s < factors.size(); ++s) {
      const JointStep& step = layout.steps[static_cast<size_t>(layout.first_step[c] + s)];
      factors[s] = factor_at(step.knot);
      if (step.beyond > 0) factors[s] += step.beyond * (factor_at(step.knot + 1) - factors[s]);
    }
    draw.log_factors.push_back(std::move(factors));
  }
  return draw;
}

}  // namespace

std::vector<JointDraw> posterior_draws(JointModel& model, const NoiseModel& noise, int n_draws,
                                       const Progress& progress) {
  std::vector<JointDraw> draws(static_cast<size_t>(n_draws));
  if (n_draws == 0) return draws;
  const NoiseModel expected = expected_noise(model, noise, progress);
  model.evaluate(expected, false, progress);
  parallel_for(
      n_draws, 1,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i) {
          Random random(kDrawSeed, static_cast<std::uint64_t>(i));
          draws[static_cast<size_t>(i)] = joint_draw(model, model.draw(expected, random));
        }
      },
      progress);
  return draws;
}

}  // namespace batten
