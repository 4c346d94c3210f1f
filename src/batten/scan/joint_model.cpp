#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/joint_model_detail.hpp"
#include "batten/scan/rate_change_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Between the knots of a factor that changes along its curve, in sizes.
constexpr double kKnotSpacing = 0.08;
/// Precision of the move of a node in one step, per square of the size: it holds the place of the whole,
/// which is free, and is far below what the curves say of a node.
constexpr double kNodePrecision = 1e-2;

double inner(const Matrix3d& a, const Matrix3d& b) {
  return a.cwiseProduct(b).sum();
}

}  // namespace

JointModel::JointModel(const SampledScan& scan, const JointOptions& options, const Progress& progress)
    : scan_(scan),
      options_(options),
      prior_(options),
      layout_(scan, options.size, options.speed_deviation > 0 ? kKnotSpacing : 0, progress),
      turns_(layout_.turns, options.turn_density.value_or(kLeastTurnDensity)) {
  reset();
  data_.resize(layout_.n_samples);
  omega_.resize(layout_.steps.size());
  rate_change_.assign(layout_.n_samples, Vector3d::Zero());
  lag_ = rate_change_;
  omega_by_.resize(layout_.steps.size());
  gram_.resize(layout_.pairs.size());
  misfit_.resize(layout_.segments.size());
  reach_.resize(layout_.segments.size());
  misfit_by_.resize(layout_.segments.size());
  for (size_t s = 0; s < misfit_by_.size(); ++s) {
    misfit_by_[s].resize(layout_.segments[s].to_frames.size());
    reach_[s].resize(layout_.segments[s].to_knots.size());
  }
}

void JointModel::reset() {
  state_.X.assign(layout_.n_frames, Matrix3d::Identity());
  state_.drift.setZero(layout_.n_samples, 3);
  state_.nodes.setZero(layout_.n_nodes, 3);
  state_.log_factors.setZero(layout_.n_knots());
  state_.trust.setOnes(layout_.n_samples);
  std::fill(lag_.begin(), lag_.end(), Vector3d::Zero());
  turns_.reset();
}

void JointModel::set_normal_deviation(double white) {
  normal_precision_ = std::max(options_.xi, 1e-6) / (2 * white * white);
}

Vector3d JointModel::reading_residual(int curve, int k) const {
  const int i = layout_.first_sample[curve] + k;
  const Matrix3d& X = state_.X[layout_.frame_of_sample[i]];
  return so3_log(scan_.curves[curve].frames[k] * so3_exp(-lag_[i]) * X.transpose()) -
         state_.drift.row(i).transpose();
}

void JointModel::linearize(const Progress& progress, bool follow) {
  parallel_for(
      layout_.n_curves, 1,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index c = begin; c < end; ++c) linearize_curve(static_cast<int>(c), follow);
      },
      progress);
  turns_.linearize(state_.X);
  n_data_ = 0;
  for (const Datum& d : data_) n_data_ += d.readings > 0 ? 1 : 0;
}

/// Rates of turn, their derivatives, and what comes of their changes.
void JointModel::find_rates(int c, bool follow) {
  const SampledCurve& curve = scan_.curves[c];
  std::vector<Vector3d> omega;
  std::vector<double> lengths;
  for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s) {
    const JointStep& step = layout_.steps[s];
    const Matrix3d &X = state_.X[step.before], &Y = state_.X[step.after];
    const Vector3d u = so3_log(X.transpose() * Y);
    omega_[s] = u / step.length;
    // log(Xᵀ exp(η' − η) Y) ≈ u + J_r⁻¹(u) Yᵀ (η' − η)
    omega_by_[s] = so3_right_jacobian_inverse(u) * Y.transpose() / step.length;
    omega.push_back(omega_[s]);
    lengths.push_back(step.length);
  }
  if (!follow) return;
  const std::vector<Vector3d> changes = rate_changes(omega, lengths, curve.smooth_seam);
  for (int k = 0; k < curve.n_samples(); ++k) {
    const int i = layout_.first_sample[c] + k;
    rate_change_[i] = changes[k];
    if (curve.lag.size() > 0) lag_[i] = curve.lag[k] / (options_.size * options_.size) * changes[k];
  }
}

void JointModel::linearize_curve(int c, bool follow) {
  const SampledCurve& curve = scan_.curves[c];
  find_rates(c, follow);
  for (int k = 0; k < curve.n_samples(); ++k) {
    const int i = layout_.first_sample[c] + k;
    Datum& d = data_[i];
    d.readings = std::max(curve.weights[k] * state_.trust[i], 0.0);
    // log(A Xᵀ exp(−η)) ≈ l − J_r⁻¹(l) η for X ← exp(η) X
    const Vector3d drift = state_.drift.row(i).transpose();
    d.residual = reading_residual(c, k);
    d.J = so3_right_jacobian_inverse(d.residual + drift);
  }
  const auto frame = [&](int f) -> const Matrix3d& { return state_.X[f]; };
  for (int p = layout_.first_pair[c]; p < layout_.first_pair[c + 1]; ++p)
    gram_[p] = omega_by_[layout_.pairs[p].k].transpose() * omega_by_[layout_.pairs[p].l];
  for (int i = layout_.first_segment[c]; i < layout_.first_segment[c + 1]; ++i) {
    const JointSegment& segment = layout_.segments[i];
    Vector3d sum = Vector3d::Zero();
    std::vector<Matrix3d>& by = misfit_by_[i];
    std::vector<Vector3d>& reach = reach_[i];
    std::fill(reach.begin(), reach.end(), Vector3d::Zero());
    std::fill(by.begin(), by.end(), Matrix3d::Zero());
    for (int s = segment.first_step; s < segment.end_step; ++s) {
      const JointStep& step = layout_.steps[s];
      const double factor = std::exp(log_factor(step)), h = factor * step.length;
      const Matrix3d &X = frame(step.before), &Y = frame(step.after);
      const Vector3d u = omega_[s] * step.length;
      Vector3d whole = h * (X * so3_right_jacobian(-u).col(0));
      const Vector3d change = 0.5 * (rate_change_[step.sample_before] + rate_change_[step.sample_before + 1]);
      whole += factor * step_of_rate_change(X, u, step.length, change);
      sum += whole;
      reach[step.knot - segment.first_knot] += (1 - step.beyond) * whole;
      if (step.beyond > 0) reach[step.knot + 1 - segment.first_knot] += step.beyond * whole;
      // The tangent at u is turned by (1 − u) η + u η'; Simpson's rule over the step gives the derivative.
      const Vector3d t0 = h * X.col(0), t1 = h * Y.col(0), tm = h * (X * so3_exp(0.5 * u)).col(0);
      by[s - segment.first_step] += hat(t0 + 2 * tm) / 6;
      by[s - segment.first_step + 1] += hat(2 * tm + t1) / 6;
    }
    misfit_[i] = (state_.nodes.row(segment.to) - state_.nodes.row(segment.from)).transpose() - sum;
  }
}

JointModel::Weights JointModel::weights_of_noise(const NoiseModel& noise) const {
  Weights w;
  w.white = 1 / (noise.white * noise.white);
  w.scale = 1 / (noise.scale * noise.scale);
  w.shape = {1 / noise.stretch, 1 / noise.bending, 1 / noise.jerk};
  // Ornstein–Uhlenbeck: b_0 ~ N(0, σ²), b_{k+1} | b_k ~ N(φ b_k, σ²(1 − φ²)), φ = exp(−h/ℓ).
  w.drift = 1 / (noise.drift * noise.drift);
  for (const JointStep& s : layout_.steps) {
    w.drift_decay.push_back(std::exp(-s.length / noise.drift_length));
    w.drift_decay_slope.push_back(w.drift_decay.back() * s.length / noise.drift_length);
    w.drift_precision.push_back(-w.drift / std::expm1(-2 * s.length / noise.drift_length));
  }
  return w;
}

void JointModel::add_pair(const StepPair& pair, const Matrix3d& block) {
  const JointStep &k = layout_.steps[pair.k], &l = layout_.steps[pair.l];
  const auto add = [&](int i, int a, int b, double sign) {
    if (a == b && pair.k != pair.l)
      layout_.system.add(pair.slots[i], sign * (block + block.transpose()));
    else
      layout_.system.add(pair.slots[i], sign * block);
  };
  add(0, k.after, l.after, 1);
  add(1, k.before, l.before, 1);
  add(2, k.after, l.before, -1);
  if (pair.k != pair.l) add(3, k.before, l.after, -1);
}

void JointModel::assemble_curve(int c, const Weights& w) {
  FrameLdlt& K = layout_.system;
  const auto right = [&](int block) { return right_.segment<3>(3 * block); };
  const auto drift = [&](int i) -> Vector3d { return state_.drift.row(i).transpose(); };
  for (int i = layout_.first_sample[c]; i < layout_.first_sample[c + 1]; ++i) {
    const Datum& d = data_[i];
    if (!(d.readings > 0)) continue;
    const double weight = w.white * d.readings;
    const int f = layout_.frame_of_sample[i];
    K.add(layout_.frame_slot[f], weight * (d.J.transpose() * d.J));
    K.add(layout_.data_slot[i], weight * d.J.transpose());
    K.add(layout_.drift_slot[i], weight * Matrix3d::Identity());
    right(f) += weight * (d.J.transpose() * d.residual);
    right(layout_.drift_at + i) += weight * d.residual;
  }
  const int first = layout_.first_sample[c];
  K.add(layout_.drift_slot[first], w.drift * Matrix3d::Identity());
  right(layout_.drift_at + first) -= w.drift * drift(first);
  for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s) {
    const int i = layout_.steps[s].sample_before;
    const double phi = w.drift_decay[s], p = w.drift_precision[s];
    const Vector3d r = drift(i + 1) - phi * drift(i);
    K.add(layout_.drift_slot[i + 1], p * Matrix3d::Identity());
    K.add(layout_.drift_slot[i], p * phi * phi * Matrix3d::Identity());
    K.add(layout_.steps[s].drift_to_next, -p * phi * Matrix3d::Identity());
    right(layout_.drift_at + i + 1) -= p * r;
    right(layout_.drift_at + i) += p * phi * r;
  }
  for (int i = layout_.first_pair[c]; i < layout_.first_pair[c + 1]; ++i) {
    const StepPair& pair = layout_.pairs[i];
    double weight = 0;
    for (int g = 0; g < 3; ++g) weight += w.shape[g] * pair.weights[g];
    add_pair(pair, weight * gram_[i]);
    const auto push = [&](int a, int b) {
      const Vector3d force = weight * (omega_by_[a].transpose() * omega_[b]);
      right(layout_.steps[a].after) -= force;
      right(layout_.steps[a].before) += force;
    };
    push(pair.k, pair.l);
    if (pair.k != pair.l) push(pair.l, pair.k);
  }
  for (int i = layout_.first_segment[c]; i < layout_.first_segment[c + 1]; ++i) {
    const JointSegment& segment = layout_.segments[i];
    K.add(segment.own, -kSlip * kSlip * segment.length * Matrix3d::Identity());
    K.add(segment.to_to, Matrix3d::Identity());
    K.add(segment.to_from, -Matrix3d::Identity());
    Matrix3d by_factor = Matrix3d::Zero();
    for (size_t j = 0; j < reach_[i].size(); ++j) {
      by_factor.col(0) = -reach_[i][j];
      K.add(segment.to_knots[j], by_factor);
    }
    for (size_t j = 0; j < misfit_by_[i].size(); ++j) K.add(segment.to_frames[j], misfit_by_[i][j]);
    right(segment.multiplier) = -misfit_[i];
  }
}

void JointModel::assemble_nodes() {
  FrameLdlt& K = layout_.system;
  const auto right = [&](int block) { return right_.segment<3>(3 * block); };
  for (size_t i = 0; i < layout_.normals.size(); ++i) {
    const auto [f, g] = layout_.normals[i];
    const Vector3d a = state_.X[f].col(1), b = state_.X[g].col(1), r = a - b;
    const Matrix3d A = -hat(a), B = hat(b);
    K.add(layout_.frame_slot[f], normal_precision_ * (A.transpose() * A));
    K.add(layout_.frame_slot[g], normal_precision_ * (B.transpose() * B));
    K.add(layout_.normal_slot[i], normal_precision_ * (A.transpose() * B));
    right(f) -= normal_precision_ * (A.transpose() * r);
    right(g) -= normal_precision_ * (B.transpose() * r);
  }
  for (const FrameLdlt::Slot slot : layout_.node_slot) K.add(slot, kNodePrecision * Matrix3d::Identity());
}

void JointModel::assemble(const Weights& weights, const Progress& progress) {
  layout_.system.clear();
  right_.setZero(3 * layout_.n_blocks);
  parallel_for(
      layout_.n_curves, 1,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index c = begin; c < end; ++c) assemble_curve(static_cast<int>(c), weights);
      },
      progress);
  assemble_nodes();
  assemble_factors(weights);
  turns_.assemble(layout_.system, right_);
}

/// What a step of the drift adds, from the products of both its ends: s00 before · before, and so on.
void JointModel::add_drift_step(int s, const Weights& w, double s00, double s01, double s11,
                                Moments& m) const {
  const double phi = w.drift_decay[s], p = w.drift_precision[s];
  const double S = s11 - 2 * phi * s01 + phi * phi * s00;
  m.drift += p * S;
  m.drift_length += w.drift_decay_slope[s] * (2 * p * (phi * s00 - s01) + 2 * phi * p * p / w.drift * S);
}

JointModel::Moments JointModel::squares_of_curve(int c, const Weights& w,
                                                 const Eigen::VectorXd& delta) const {
  const auto by = [&](int block) { return delta.segment<3>(3 * block); };
  Moments m;
  for (int i = layout_.first_sample[c]; i < layout_.first_sample[c + 1]; ++i) {
    const Datum& d = data_[i];
    const Vector3d r = d.residual - d.J * by(layout_.frame_of_sample[i]) - by(layout_.drift_at + i);
    m.white += d.readings * r.squaredNorm();
  }
  const auto drift = [&](int i) -> Vector3d {
    return state_.drift.row(i).transpose() + by(layout_.drift_at + i);
  };
  m.drift = w.drift * drift(layout_.first_sample[c]).squaredNorm();
  const auto omega = [&](int s) -> Vector3d {
    return omega_[s] + omega_by_[s] * (by(layout_.steps[s].after) - by(layout_.steps[s].before));
  };
  for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s) {
    const Vector3d a = drift(layout_.steps[s].sample_before), b = drift(layout_.steps[s].sample_before + 1);
    add_drift_step(s, w, a.squaredNorm(), a.dot(b), b.squaredNorm(), m);
  }
  for (int i = layout_.first_pair[c]; i < layout_.first_pair[c + 1]; ++i) {
    const StepPair& pair = layout_.pairs[i];
    const double product = (pair.k == pair.l ? 1 : 2) * omega(pair.k).dot(omega(pair.l));
    for (int g = 0; g < 3; ++g) m.shape[g] += pair.weights[g] * product;
  }
  return m;
}

/// The same of the posterior covariance.
JointModel::Moments JointModel::traces_of_curve(int c, const Weights& w) const {
  const FrameLdlt& K = layout_.system;
  Moments m;
  for (int i = layout_.first_sample[c]; i < layout_.first_sample[c + 1]; ++i) {
    const Datum& d = data_[i];
    if (!(d.readings > 0)) continue;
    const Matrix3d frame = K.inverse(layout_.frame_slot[layout_.frame_of_sample[i]]);
    m.white += d.readings * (inner(d.J.transpose() * d.J, frame) +
                             2 * inner(d.J.transpose(), K.inverse(layout_.data_slot[i])) +
                             K.inverse(layout_.drift_slot[i]).trace());
  }
  const auto drift = [&](int i) { return K.inverse(layout_.drift_slot[i]).trace(); };
  m.drift = w.drift * drift(layout_.first_sample[c]);
  for (int s = layout_.first_step[c]; s < layout_.first_step[c + 1]; ++s) {
    const JointStep& step = layout_.steps[s];
    add_drift_step(s, w, drift(step.sample_before), K.inverse(step.drift_to_next).trace(),
                   drift(step.sample_before + 1), m);
  }
  for (int i = layout_.first_pair[c]; i < layout_.first_pair[c + 1]; ++i) {
    const StepPair& pair = layout_.pairs[i];
    Matrix3d Z = K.inverse(pair.slots[0]) + K.inverse(pair.slots[1]) - K.inverse(pair.slots[2]);
    Z -= pair.k == pair.l ? K.inverse(pair.slots[2]).transpose() : K.inverse(pair.slots[3]);
    const double trace = (pair.k == pair.l ? 1 : 2) * inner(gram_[i], Z);
    for (int g = 0; g < 3; ++g) m.shape[g] += pair.weights[g] * trace;
  }
  return m;
}

template <typename OfCurve>
JointModel::Moments JointModel::sum_over_curves(const OfCurve& of_curve) const {
  std::vector<Moments> parts(layout_.n_curves);
  parallel_for(layout_.n_curves, 1, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index c = begin; c < end; ++c) parts[c] = of_curve(static_cast<int>(c));
  });
  Moments sum;
  for (const Moments& part : parts) {
    sum.white += part.white;
    sum.drift += part.drift;
    sum.drift_length += part.drift_length;
    for (int g = 0; g < 3; ++g) sum.shape[g] += part.shape[g];
  }
  return sum;
}

/// What does not depend on the noise model at the optimum: agreement of the normals, segments, nodes, mean
/// factor, gyroscope.
double JointModel::constraint_energy(const Eigen::VectorXd& delta) const {
  const auto by = [&](int block) { return delta.segment<3>(3 * block); };
  double sum = 0;
  for (const auto& [f, g] : layout_.normals) {
    const Vector3d a = state_.X[f].col(1), b = state_.X[g].col(1);
    sum += normal_precision_ * (a - b + by(f).cross(a) - by(g).cross(b)).squaredNorm();
  }
  for (const JointSegment& s : layout_.segments)
    sum += kSlip * kSlip * s.length * by(s.multiplier).squaredNorm();
  sum += turns_.energy(delta);
  for (int v = 0; v < layout_.n_nodes; ++v) sum += kNodePrecision * by(layout_.node_at + v).squaredNorm();
  return sum;
}

/// log det of the precision of the rates of turn, of one component; with the shares of its three parts.
double JointModel::log_determinant_of_shape(const Weights& w, bool with_traces, std::array<double, 3>& traces,
                                            const Progress& progress) {
  BlockLdlt<1>& P = layout_.shape;
  P.clear();
  for (const StepPair& pair : layout_.pairs) {
    double weight = 0;
    for (int g = 0; g < 3; ++g) weight += w.shape[g] * pair.weights[g];
    P.add(pair.scalar, BlockLdlt<1>::Block(weight));
  }
  if (!P.factorize(progress)) throw SolverFailure("prior of the shape", P.size());
  if (with_traces) {
    P.invert(progress);
    traces = {0, 0, 0};
    for (const StepPair& pair : layout_.pairs)
      for (int g = 0; g < 3; ++g)
        traces[g] += (pair.k == pair.l ? 1 : 2) * pair.weights[g] * P.inverse(pair.scalar)(0, 0);
  }
  return P.log_determinant();
}

NoiseEvaluation JointModel::evaluate(const NoiseModel& noise, bool with_slope, const Progress& progress) {
  const Weights w = weights_of_noise(noise);
  progress.report("working", 0.5);
  assemble(w, progress);
  progress.report("working", 0.5);
  if (!layout_.system.factorize(progress))
    throw SolverFailure("joint estimate of frames and positions", 3L * layout_.n_blocks);
  NoiseEvaluation result;
  progress.report("working", 0.5);
  result.step = layout_.system.solve(right_);
  progress.report("working", 0.5);
  const Moments squares = sum_over_curves([&](int c) { return squares_of_curve(c, w, result.step); });
  double factors = 0;
  const double of_factors = factor_energy(w, result.step, factors);
  std::array<double, 3> shape_traces{};
  const double shape = log_determinant_of_shape(w, with_slope, shape_traces, progress);
  double innovations = -layout_.n_curves * std::log(w.drift);
  for (const double p : w.drift_precision) innovations -= std::log(p);
  const NoisePrior::Coordinates u = prior_.coordinates(noise);
  result.evidence = w.white * squares.white + squares.drift + of_factors + constraint_energy(result.step) +
                    layout_.system.log_determinant() - 3.0 * n_data_ * std::log(w.white) + 3 * innovations -
                    3 * shape + prior_(u);
  for (int g = 0; g < 3; ++g) result.evidence += w.shape[g] * squares.shape[g];
  if (!std::isfinite(result.evidence))
    throw SolverFailure("joint estimate of frames and positions", 3L * layout_.n_blocks);
  if (!with_slope) return result;

  layout_.system.invert(progress);
  progress.report("working", 0.5);
  const Moments traces = sum_over_curves([&](int c) { return traces_of_curve(c, w); });
  double factor_variance = 0;
  for (const FrameLdlt::Slot slot : layout_.scale_slot) factor_variance += layout_.system.inverse(slot)(0, 0);
  double decay = 0;  // derivative of Σ log innovation by log ℓ
  for (size_t s = 0; s < w.drift_decay.size(); ++s)
    decay -= 2 * w.drift_decay[s] * w.drift_precision[s] / w.drift * w.drift_decay_slope[s];
  // Derivatives by the logarithms of the figures, and the squares that stand behind each of them.
  NoisePrior::Coordinates slope, effective;
  slope[NoisePrior::kWhite] = 6.0 * n_data_ - 2 * w.white * (squares.white + traces.white);
  slope[NoisePrior::kDrift] = 6.0 * layout_.n_samples - 2 * (squares.drift + traces.drift);
  slope[NoisePrior::kDriftLength] = squares.drift_length + traces.drift_length + 3 * decay;
  slope[NoisePrior::kScale] = 2.0 * layout_.n_curves - 2 * w.scale * (factors + factor_variance);
  effective[NoisePrior::kWhite] = 4 * w.white * squares.white;
  effective[NoisePrior::kDrift] = 4 * squares.drift;
  effective[NoisePrior::kDriftLength] = squares.drift;
  effective[NoisePrior::kScale] = 4 * w.scale * factors;
  for (int g = 0; g < 3; ++g) {
    slope[NoisePrior::kStretch + g] = w.shape[g] * (3 * shape_traces[g] - squares.shape[g] - traces.shape[g]);
    effective[NoisePrior::kStretch + g] = w.shape[g] * squares.shape[g];
  }
  for (int i = 0; i < NoisePrior::kFigures; ++i) {
    result.slope[i] = slope[i] * prior_.scale(i) + 2 * u[i];
    result.weight[i] = effective[i] * prior_.scale(i) * prior_.scale(i) + 2;
  }
  return result;
}

double JointModel::apply(const Eigen::VectorXd& step) {
  double largest = 0;
  for (int f = 0; f < layout_.n_frames; ++f) {
    const Vector3d d = step.segment<3>(3 * f);
    largest = std::max(largest, d.norm());
    state_.X[f] = so3_exp(d) * state_.X[f];
  }
  turns_.apply(step);
  for (int i = 0; i < layout_.n_samples; ++i)
    state_.drift.row(i) += step.segment<3>(3 * (layout_.drift_at + i)).transpose();
  for (int v = 0; v < layout_.n_nodes; ++v)
    state_.nodes.row(v) += step.segment<3>(3 * (layout_.node_at + v)).transpose();
  for (int k = 0; k < layout_.n_knots(); ++k) state_.log_factors[k] += step[3 * (layout_.scale_at + k)];
  return largest;
}

}  // namespace batten
