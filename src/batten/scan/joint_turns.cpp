#include <cmath>

#include "batten/rotation/so3.hpp"
#include "batten/scan/joint_turns_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What is uncertain of a turn beside the noise, as a part of it and radians.
constexpr double kTurnPart = 0.003, kTurnFloor = 1e-4;
/// Deviations of the bias at the start, rad/s, of its walk, rad/s/√s, and of each entry of the matrix. The
/// walk is that of a device which grows warm.
constexpr double kFirstBias = 0.05, kBiasWalk = 1e-4, kAxesDeviation = 0.01;

/// The bias of a gyroscope is one for so many seconds, and then another that lies near it.
constexpr double kBiasTime = 10;
/// A pause of which the log does not tell how long it was, seconds.
constexpr double kUnknownPause = 60;

double square_of(double x) {
  return x * x;
}

}  // namespace

/// The turns of the gyroscope along the curves and from curve to curve.
void TurnLayout::find(const SampledScan& scan, const FrameNumbering& frames, int& n_blocks) {
  double since = 0;  // the bias was given a new block
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    if (curve.turns.rows() != curve.n_samples()) continue;
    for (int k = 0; k < curve.n_samples(); ++k) {
      const double time = std::isfinite(curve.turn_times[k]) ? curve.turn_times[k] : kUnknownPause;
      since += time;
      if (bias_times.empty() || since > kBiasTime) {
        bias_times.push_back(bias_times.empty() ? 0 : since);
        since = 0;
      }
      const bool first = k == 0;
      if (!curve.turns.row(k).allFinite() || (first && c == 0)) continue;
      const int before = first ? frames.frames[c - 1].back() : frames.frames[c][k - 1];
      const int after = frames.frames[c][k];
      if (before == after) continue;
      turns.push_back({before, after, curve.turns.row(k), time, n_biases() - 1});
    }
  }
  if (turns.empty()) {
    bias_times.clear();
    return;
  }
  bias_at = n_blocks;
  matrix_at = bias_at + static_cast<int>(bias_times.size());
  n_blocks = matrix_at + 3;
}

void TurnLayout::join(std::vector<std::pair<int, int>>& list) const {
  if (turns.empty()) return;
  for (const JointTurn& t : turns) {
    list.emplace_back(t.before, t.after);
    for (const int frame : {t.before, t.after}) {
      list.emplace_back(bias_at + t.bias, frame);
      for (int j = 0; j < 3; ++j) list.emplace_back(matrix_at + j, frame);
    }
    for (int j = 0; j < 3; ++j) list.emplace_back(matrix_at + j, bias_at + t.bias);
  }
  for (int b = 0; b + 1 < n_biases(); ++b) list.emplace_back(bias_at + b, bias_at + b + 1);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) list.emplace_back(matrix_at + i, matrix_at + j);
}

void TurnLayout::find_slots(const FrameLdlt& system) {
  if (turns.empty()) return;
  for (JointTurn& t : turns) {
    t.own_before = system.slot(t.before, t.before);
    t.own_after = system.slot(t.after, t.after);
    t.to_after = system.slot(t.before, t.after);
    t.bias_before = system.slot(bias_at + t.bias, t.before);
    t.bias_after = system.slot(bias_at + t.bias, t.after);
    for (int j = 0; j < 3; ++j) {
      t.matrix_before[j] = system.slot(matrix_at + j, t.before);
      t.matrix_after[j] = system.slot(matrix_at + j, t.after);
      t.matrix_bias[j] = system.slot(matrix_at + j, bias_at + t.bias);
    }
  }
  for (int b = 0; b < n_biases(); ++b) {
    bias_own.push_back(system.slot(bias_at + b, bias_at + b));
    if (b + 1 < n_biases()) bias_next.push_back(system.slot(bias_at + b, bias_at + b + 1));
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) matrix_slot[i][j] = system.slot(matrix_at + i, matrix_at + j);
}

void JointTurns::reset() {
  biases_.setZero(layout_.n_biases(), 3);
  matrix_.setZero();
}

double JointTurns::weight_of(const JointTurn& turn) const {
  return 1 /
         (square_of(density_) * turn.time + square_of(kTurnPart * turn.turn.norm()) + square_of(kTurnFloor));
}

void JointTurns::set_density(double density) {
  density_ = density;
  for (size_t i = 0; i < linear_.size(); ++i) linear_[i].weight = weight_of(layout_.turns[i]);
}

void JointTurns::linearize(const std::vector<Matrix3d>& X) {
  linear_.resize(layout_.turns.size());
  for (size_t i = 0; i < layout_.turns.size(); ++i) {
    const JointTurn& t = layout_.turns[i];
    Linear& l = linear_[i];
    l.rate = t.turn - t.time * biases_.row(t.bias).transpose();
    const Vector3d turn = l.rate + matrix_ * l.rate;
    l.residual = so3_log(so3_exp(turn).transpose() * X[t.before].transpose() * X[t.after]);
    const Matrix3d J = so3_right_jacobian_inverse(l.residual);
    // log(Gᵀ Xᵀ exp(η' − η) Y) ≈ r + J_r⁻¹(r) Yᵀ (η' − η)
    l.by_frames = J * X[t.after].transpose();
    l.by_turn = -J * so3_exp(l.residual).transpose() * so3_right_jacobian(turn);
    l.weight = weight_of(t);
  }
}

void JointTurns::assemble(FrameLdlt& K, Eigen::VectorXd& right) const {
  if (empty()) return;
  const auto at = [&](int block) { return right.segment<3>(3 * block); };
  const int matrix = layout_.matrix_at;
  for (size_t i = 0; i < linear_.size(); ++i) {
    const JointTurn& t = layout_.turns[i];
    const Linear& l = linear_[i];
    const int bias = layout_.bias_at + t.bias;
    const Matrix3d by_bias = -t.time * (l.by_turn + l.by_turn * matrix_);
    const Matrix3d F = l.weight * l.by_frames.transpose(), B = l.weight * by_bias.transpose();
    const Matrix3d FF = F * l.by_frames;
    K.add(t.own_before, FF);
    K.add(t.own_after, FF);
    K.add(t.to_after, -FF);
    const Matrix3d BF = B * l.by_frames;
    K.add(t.bias_after, BF);
    K.add(t.bias_before, -BF);
    K.add(layout_.bias_own[t.bias], B * by_bias);
    const Matrix3d T = l.weight * l.by_turn.transpose();
    const Matrix3d TF = T * l.by_frames, TB = T * by_bias, TT = T * l.by_turn;
    for (int j = 0; j < 3; ++j) {
      K.add(t.matrix_after[j], l.rate[j] * TF);
      K.add(t.matrix_before[j], -l.rate[j] * TF);
      K.add(t.matrix_bias[j], l.rate[j] * TB);
      for (int k = 0; k <= j; ++k) K.add(layout_.matrix_slot[j][k], l.rate[j] * l.rate[k] * TT);
      at(matrix + j) -= l.rate[j] * (T * l.residual);
    }
    at(t.after) -= F * l.residual;
    at(t.before) += F * l.residual;
    at(bias) -= B * l.residual;
  }
  const auto bias = [&](int b) -> Vector3d { return biases_.row(b); };
  for (int b = 0; b < layout_.n_biases(); ++b) {
    const double w = b == 0 ? 1 / square_of(kFirstBias) : 1 / (square_of(kBiasWalk) * layout_.bias_times[b]);
    const Vector3d r = b == 0 ? bias(0) : bias(b) - bias(b - 1);
    K.add(layout_.bias_own[b], w * Matrix3d::Identity());
    at(layout_.bias_at + b) -= w * r;
    if (b == 0) continue;
    K.add(layout_.bias_own[b - 1], w * Matrix3d::Identity());
    K.add(layout_.bias_next[b - 1], -w * Matrix3d::Identity());
    at(layout_.bias_at + b - 1) += w * r;
  }
  for (int j = 0; j < 3; ++j) {
    K.add(layout_.matrix_slot[j][j], 1 / square_of(kAxesDeviation) * Matrix3d::Identity());
    at(matrix + j) -= 1 / square_of(kAxesDeviation) * matrix_.col(j);
  }
}

void JointTurns::draw(Random& random, Eigen::VectorXd& right) const {
  if (empty()) return;
  const auto at = [&](int block) { return right.segment<3>(3 * block); };
  for (size_t i = 0; i < linear_.size(); ++i) {
    const JointTurn& t = layout_.turns[i];
    const Linear& l = linear_[i];
    const Vector3d noise = std::sqrt(l.weight) * random.normal3();
    const Vector3d by_frames = l.by_frames.transpose() * noise, by_turn = l.by_turn.transpose() * noise;
    at(t.after) += by_frames;
    at(t.before) -= by_frames;
    at(layout_.bias_at + t.bias) -= t.time * (by_turn + matrix_.transpose() * by_turn);
    for (int j = 0; j < 3; ++j) at(layout_.matrix_at + j) += l.rate[j] * by_turn;
  }
  for (int b = 0; b < layout_.n_biases(); ++b) {
    const double deviation = b == 0 ? kFirstBias : kBiasWalk * std::sqrt(layout_.bias_times[b]);
    const Vector3d noise = random.normal3() / deviation;
    at(layout_.bias_at + b) += noise;
    if (b > 0) at(layout_.bias_at + b - 1) -= noise;
  }
  for (int j = 0; j < 3; ++j) at(layout_.matrix_at + j) += random.normal3() / kAxesDeviation;
}

double JointTurns::energy(const Eigen::VectorXd& delta) const {
  if (empty()) return 0;
  const auto by = [&](int block) -> Vector3d { return delta.segment<3>(3 * block); };
  double sum = 0;
  Matrix3d matrix_step;
  for (int j = 0; j < 3; ++j) matrix_step.col(j) = by(layout_.matrix_at + j);
  for (size_t i = 0; i < linear_.size(); ++i) {
    const JointTurn& t = layout_.turns[i];
    const Linear& l = linear_[i];
    const Vector3d bias = -t.time * by(layout_.bias_at + t.bias);
    const Vector3d r = l.residual + l.by_frames * (by(t.after) - by(t.before)) +
                       l.by_turn * (bias + matrix_ * bias + matrix_step * l.rate);
    sum += l.weight * r.squaredNorm() - 3 * std::log(l.weight);
  }
  const auto bias = [&](int b) -> Vector3d { return biases_.row(b).transpose() + by(layout_.bias_at + b); };
  sum += bias(0).squaredNorm() / square_of(kFirstBias);
  for (int b = 1; b < layout_.n_biases(); ++b)
    sum += (bias(b) - bias(b - 1)).squaredNorm() / (square_of(kBiasWalk) * layout_.bias_times[b]);
  return sum + (matrix_ + matrix_step).squaredNorm() / square_of(kAxesDeviation);
}

void JointTurns::apply(const Eigen::VectorXd& delta) {
  if (empty()) return;
  for (Eigen::Index b = 0; b < biases_.rows(); ++b)
    biases_.row(b) += delta.segment<3>(3 * (layout_.bias_at + b)).transpose();
  for (int j = 0; j < 3; ++j) matrix_.col(j) += delta.segment<3>(3 * (layout_.matrix_at + j));
}

}  // namespace batten
