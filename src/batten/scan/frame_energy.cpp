// The energy of the regression on SO(3), S 3.5.4 with the corrections of the errata, and its derivatives. The
// discrete energy is that of N. Boumal, Interpolation and regression of rotation matrices, GSI 2013.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "batten/rotation/so3.hpp"
#include "batten/scan/frame_energy_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// R = XᵀY and its half-angle form q = (v, w) with w ≥ 0, |v| = sin(θ/2).
struct HalfTurn {
  Matrix3d R;
  Vector3d v;
  double w;
};

HalfTurn half_turn(const Matrix3d& X, const Matrix3d& Y) {
  HalfTurn q;
  q.R = X.transpose() * Y;
  const double trace = q.R.trace();
  if (trace > 0) {  // below 120°: every case but wild data
    q.w = 0.5 * std::sqrt(1 + trace);
    q.v = 0.25 / q.w * Vector3d(q.R(2, 1) - q.R(1, 2), q.R(0, 2) - q.R(2, 0), q.R(1, 0) - q.R(0, 1));
    return q;
  }
  const Eigen::Quaterniond full(q.R);
  const double sign = full.w() < 0 ? -1 : 1;
  q.v = sign * full.vec();
  q.w = sign * full.w();
  return q;
}

/// skew(XᵀY) as a vector, sin θ times the axis = 2 w v, with its derivatives for X exp(δ), Y exp(ε).
struct Skew {
  Matrix3d R;
  Vector3d s;
  Matrix3d by_X, by_Y;
};

Skew skew(const Matrix3d& X, const Matrix3d& Y) {
  const HalfTurn q = half_turn(X, Y);
  Skew s;
  s.R = q.R;
  s.s = 2 * q.w * q.v;
  const Matrix3d V = hat(q.v), W = q.w * Matrix3d::Identity();
  const Matrix3d outer = q.v * q.v.transpose();
  // d(2 w v) = 2 w dv + 2 v dw, dv = −½(w I − v^) δ + ½(w I + v^) ε, dw = ½ vᵀδ − ½ vᵀε.
  s.by_X = -q.w * (W - V) + outer;
  s.by_Y = q.w * (W + V) - outer;
  return s;
}

/// Second derivatives of 2 u·skew(XᵀY) for a fixed u, as the form δᵀ XX δ + εᵀ YY ε + δᵀ XY ε + its
/// transpose.
struct SkewCurvature {
  Matrix3d XX, YY, XY;
};

SkewCurvature curvature_of(const Skew& s, const Vector3d& u) {
  // u·skew(R) = −½ tr(u^ R) with R → exp(−δ^) R exp(ε^), expanded to second order.
  const Matrix3d U = hat(u);
  const Matrix3d RU = s.R * U, UR = U * s.R;
  const Matrix3d trace = u.dot(s.s) * Matrix3d::Identity();
  return {-0.25 * (RU + RU.transpose()) - trace, -0.25 * (UR + UR.transpose()) - trace,
          0.5 * hat(s.R * u) + s.s * u.transpose()};
}

double squared(double x) {
  return x * x;
}

}  // namespace

BlockSystem::BlockSystem(int n_frames, const std::vector<std::pair<int, int>>& joined)
    : solver_("regression of the frames") {
  const int n = n_frames;
  std::vector<std::vector<int>> below(n);  // block rows under the diagonal, per block column
  for (const auto& [a, b] : joined)
    if (a != b) below[std::min(a, b)].push_back(std::max(a, b));
  H_.resize(3 * n, 3 * n);
  first_block_.assign(n + 1, 0);
  for (int j = 0; j < n; ++j) {
    std::sort(below[j].begin(), below[j].end());
    below[j].erase(std::unique(below[j].begin(), below[j].end()), below[j].end());
    first_block_[j + 1] = first_block_[j] + static_cast<int>(below[j].size()) + 1;
  }
  rows_.resize(first_block_[n]);
  columns_.resize(first_block_[n]);
  H_.resizeNonZeros(9 * static_cast<Eigen::Index>(first_block_[n]));
  int* outer = H_.outerIndexPtr();
  int* inner = H_.innerIndexPtr();
  outer[0] = 0;
  for (int j = 0; j < n; ++j) {
    rows_[first_block_[j]] = j;
    std::copy(below[j].begin(), below[j].end(), rows_.begin() + first_block_[j] + 1);
    const int n_blocks = first_block_[j + 1] - first_block_[j];
    for (int b = 0; b < n_blocks; ++b) columns_[first_block_[j] + b] = j;
    for (int c = 0; c < 3; ++c) {
      int* column = inner + outer[3 * j + c];
      for (int b = 0; b < n_blocks; ++b)
        for (int r = 0; r < 3; ++r) column[3 * b + r] = 3 * rows_[first_block_[j] + b] + r;
      outer[3 * j + c + 1] = outer[3 * j + c] + 3 * n_blocks;
    }
  }
  clear();
}

int BlockSystem::block(int a, int b) const {
  const auto first = rows_.begin() + first_block_[std::min(a, b)];
  const auto end = rows_.begin() + first_block_[std::min(a, b) + 1];
  return static_cast<int>(std::lower_bound(first, end, std::max(a, b)) - rows_.begin());
}

void BlockSystem::clear() {
  std::fill(H_.valuePtr(), H_.valuePtr() + H_.nonZeros(), 0.0);
  gradient_.setZero(H_.rows());
}

void BlockSystem::add(int block, const Matrix3d& K) {
  const int column = columns_[block], first = first_block_[column];
  const int stride = 3 * (first_block_[column + 1] - first);
  double* place = H_.valuePtr() + H_.outerIndexPtr()[3 * column] + 3 * (block - first);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) place[c * stride + r] += K(r, c);
}

void BlockSystem::add_cross(int block, int a, int b, const Matrix3d& K) {
  if (a >= b) add(block, K);
  if (a <= b) add(block, K.transpose());  // a ring of two steps meets itself: both fall on one block
}

bool BlockSystem::solve(double damping, Eigen::VectorXd& delta, const Progress& progress) {
  std::vector<double> diagonal;
  const auto entry = [&](Eigen::Index i) -> double& { return H_.valuePtr()[H_.outerIndexPtr()[i] + i % 3]; };
  if (damping > 0)
    for (Eigen::Index i = 0; i < H_.rows(); ++i) {
      diagonal.push_back(entry(i));
      entry(i) += damping * std::abs(entry(i));
    }
  const bool definite = solver_.try_factorize(H_, progress);
  for (size_t i = 0; i < diagonal.size(); ++i) entry(static_cast<Eigen::Index>(i)) = diagonal[i];
  if (definite) delta = -solver_.solve(gradient_);
  return definite;
}

FrameEnergy::FrameEnergy(const SampledScan& scan) : numbering_(number_frames(scan)) {
  long n_steps = 0;
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    const SampledCurve& curve = scan.curves[c];
    const std::vector<int>& frames = numbering_.frames[c];
    const int n = curve.n_samples();
    const bool ring = curve.smooth_seam;
    samples_.push_back(n);
    n_steps += n - 1;
    mean_step_ += curve.length();
    for (int k = 0; k < (ring ? n - 1 : n); ++k) {
      // The length that the sample stands for: half of the steps on both sides.
      const double before = k > 0 ? curve.step(k - 1) : (ring ? curve.step(n - 2) : 0);
      const double after = k < n - 1 ? curve.step(k) : 0;
      data_.push_back({frames[k], c, k, 0.5 * (before + after), curve.frames[k], 1});
    }
    for (int k = 0; k < n - 1; ++k) stretch_.push_back({frames[k], frames[k + 1], 0, curve.step(k), 0});
    const auto bend = [&](int a, int b, int d, double before, double after) {
      bend_.push_back({a, b, d, 0, 0, 0, before, after, 0, 0, 0});
    };
    for (int k = 1; k < n - 1; ++k)
      bend(frames[k - 1], frames[k], frames[k + 1], curve.step(k - 1), curve.step(k));
    if (ring && n > 2) bend(frames[n - 2], frames[0], frames[1], curve.step(n - 2), curve.step(0));
  }
  if (n_steps > 0) mean_step_ /= static_cast<double>(n_steps);
  for (const auto& [i, j] : numbering_.node_pairs) normals_.push_back({i, j, 0});
}

void FrameEnergy::set_data(const SampledScan& scan) {
  for (Data& d : data_) d.A = scan.curves[d.curve].frames[d.sample];
}

void FrameEnergy::set_weights(const RegressionOptions& options) {
  const bool thesis = options.energy == RegressionEnergy::Thesis;
  lambda_ = options.lambda;
  mu_ = options.mu;
  normal_weight_ = options.xi * (thesis || stretch_.empty() ? 1 : mean_step_ / options.unit);
  for (Data& d : data_) d.weight = thesis ? 1 : d.length / options.unit;
  for (Pair& p : stretch_) p.weight = options.unit / p.length;
  for (Triple& t : bend_) {
    t.h_before = t.length_before / options.unit;
    t.h_after = t.length_after / options.unit;
    t.weight = 2 / (t.h_before + t.h_after);
  }
}

Frames FrameEnergy::frames_of(const SampledScan& scan) const {
  Frames X(numbering_.n_frames, Matrix3d::Identity());
  // Backwards, so that the first of two samples with one frame decides.
  for (size_t c = 0; c < scan.curves.size(); ++c)
    for (int k = scan.curves[c].n_samples() - 1; k >= 0; --k)
      X[numbering_.frames[c][k]] = scan.curves[c].frames[k];
  return X;
}

std::vector<std::pair<int, int>> FrameEnergy::couplings() const {
  std::vector<std::pair<int, int>> pairs = numbering_.node_pairs;
  for (const Pair& p : stretch_) pairs.emplace_back(p.a, p.b);
  for (const Triple& t : bend_) pairs.emplace_back(t.before, t.after);
  return pairs;
}

void FrameEnergy::bind(const BlockSystem& system) {
  for (Pair& p : stretch_) p.block = system.block(p.a, p.b);
  for (Normals& p : normals_) p.block = system.block(p.a, p.b);
  for (Triple& t : bend_) {
    t.block_before = system.block(t.before, t.at);
    t.block_after = system.block(t.at, t.after);
    t.block_across = system.block(t.before, t.after);
  }
}

RegressionReport FrameEnergy::energies(const Frames& X, double robust_scale) const {
  RegressionReport report;
  double data = 0;
  // Geman–McClure: ρ = c² e/(c² + e), e ≈ 2θ², c² = 2 (radians)².
  const double c2 = 2 * squared(robust_scale);
  for (const Data& d : data_) {
    const double e = (X[d.frame] - d.A).squaredNorm();
    report.E_0 += d.weight * e;
    data += d.weight * (robust_scale > 0 ? c2 * e / (c2 + e) : e);
  }
  for (const Pair& p : stretch_) report.E_1 += p.weight * (X[p.a] - X[p.b]).squaredNorm();
  for (const Triple& t : bend_) {
    // skew(XᵀY) without its derivatives; ‖a^‖²_F = 2‖a‖²
    const Matrix3d P = X[t.at].transpose() * (X[t.after] / t.h_after + X[t.before] / t.h_before);
    const Vector3d r(P(2, 1) - P(1, 2), P(0, 2) - P(2, 0), P(1, 0) - P(0, 1));
    report.E_2 += t.weight * 0.5 * r.squaredNorm();
  }
  for (const Normals& p : normals_) report.E_N += (X[p.a].col(1) - X[p.b].col(1)).squaredNorm();
  report.energy = normal_weight_ * report.E_N + data + lambda_ * report.E_1 + mu_ * report.E_2;
  return report;
}

void FrameEnergy::assemble(const Frames& X, double robust_scale, Curvature curvature,
                           BlockSystem& system) const {
  system.clear();
  add_data(X, robust_scale, curvature, system);
  if (lambda_ > 0) add_stretch(X, curvature, system);
  if (mu_ > 0) add_bend(X, curvature, system);
  if (normal_weight_ > 0) add_normals(X, curvature, system);
}

void FrameEnergy::add_data(const Frames& X, double robust_scale, Curvature curvature,
                           BlockSystem& system) const {
  const double c2 = 2 * squared(robust_scale);
  for (const Data& d : data_) {
    // e = ‖X − A‖² = 8|v|². Half its gradient is −4 w v, half its Hessian 2(w² I − v vᵀ); with the derivative
    // of w left out, as Gauss–Newton does, 2(I − v vᵀ).
    const HalfTurn q = half_turn(X[d.frame], d.A);
    const Vector3d g = -4 * q.w * q.v;
    const double e = 8 * q.v.squaredNorm();
    const double t = robust_scale > 0 ? c2 / (c2 + e) : 1;
    const double first = t * t;  // ρ'
    Matrix3d H = (curvature == Curvature::Exact ? 2 * q.w * q.w : 2.0) * Matrix3d::Identity() -
                 2 * q.v * q.v.transpose();
    H *= first;
    // ρ'' = −2 t³/c²: where the residual is large, the loss bends down.
    if (curvature == Curvature::Exact && robust_scale > 0) H -= 4 * t * t * t / c2 * g * g.transpose();
    system.add_gradient(d.frame, d.weight * first * g);
    system.add_diagonal(d.frame, d.weight * H);
  }
}

void FrameEnergy::add_stretch(const Frames& X, Curvature curvature, BlockSystem& system) const {
  for (const Pair& p : stretch_) {
    const HalfTurn q = half_turn(X[p.a], X[p.b]);
    const double w = lambda_ * p.weight;
    const Matrix3d outer = q.v * q.v.transpose(), V = hat(q.v);
    const Vector3d g = w * 4 * q.w * q.v;
    system.add_gradient(p.a, -g);
    system.add_gradient(p.b, g);
    const bool exact = curvature == Curvature::Exact;
    const Matrix3d own = 2 * w * ((exact ? q.w * q.w : 1.0) * Matrix3d::Identity() - outer);
    const Matrix3d WV = q.w * Matrix3d::Identity() + V;
    const Matrix3d cross = exact ? Matrix3d(2 * w * (outer - q.w * WV)) : Matrix3d(-2 * w * WV * WV);
    system.add_diagonal(p.a, own);
    system.add_diagonal(p.b, own);
    system.add_cross(p.block, p.a, p.b, cross);
  }
}

void FrameEnergy::add_bend(const Frames& X, Curvature curvature, BlockSystem& system) const {
  for (const Triple& t : bend_) {
    const Skew after = skew(X[t.at], X[t.after]), before = skew(X[t.at], X[t.before]);
    const Vector3d r = after.s / t.h_after + before.s / t.h_before;
    const double w = 2 * mu_ * t.weight;
    const Matrix3d B = before.by_Y / t.h_before, A = after.by_Y / t.h_after;
    const Matrix3d T = after.by_X / t.h_after + before.by_X / t.h_before;
    Matrix3d BB = B.transpose() * B, TT = T.transpose() * T, AA = A.transpose() * A;
    Matrix3d TB = T.transpose() * B, TA = T.transpose() * A;
    if (curvature == Curvature::Exact) {
      const SkewCurvature b = curvature_of(before, r / t.h_before), a = curvature_of(after, r / t.h_after);
      TT += b.XX + a.XX;
      BB += b.YY;
      AA += a.YY;
      TB += b.XY;
      TA += a.XY;
    }
    system.add_gradient(t.before, w * B.transpose() * r);
    system.add_gradient(t.at, w * T.transpose() * r);
    system.add_gradient(t.after, w * A.transpose() * r);
    system.add_diagonal(t.before, w * BB);
    system.add_diagonal(t.at, w * TT);
    system.add_diagonal(t.after, w * AA);
    system.add_cross(t.block_before, t.at, t.before, w * TB);
    system.add_cross(t.block_after, t.at, t.after, w * TA);
    system.add_cross(t.block_across, t.before, t.after, w * B.transpose() * A);
  }
}

void FrameEnergy::add_normals(const Frames& X, Curvature curvature, BlockSystem& system) const {
  const Vector3d y = Vector3d::UnitY();
  const Matrix3d Y = hat(y);
  for (const Normals& p : normals_) {
    // e = 2 − 2 n·m, n = X y and m = Z y; q = Xᵀm and p = Zᵀn see the other normal from their own frame.
    const Matrix3d R = X[p.a].transpose() * X[p.b];
    const Vector3d in_a = R.col(1), in_b = R.row(1).transpose();
    const double w = normal_weight_;
    system.add_gradient(p.a, -w * y.cross(in_a));
    system.add_gradient(p.b, -w * y.cross(in_b));
    const auto own = [&](const Vector3d& other) -> Matrix3d {
      if (curvature == Curvature::GaussNewton) return -w * Y * Y;
      const Matrix3d outer = other * y.transpose();
      return w * (y.dot(other) * Matrix3d::Identity() - 0.5 * (outer + outer.transpose()));
    };
    system.add_diagonal(p.a, own(in_a));
    system.add_diagonal(p.b, own(in_b));
    system.add_cross(p.block, p.a, p.b, w * Y * R * Y);
  }
}

double FrameEnergy::median_residual(const Frames& X) const {
  std::vector<double> angles;
  angles.reserve(data_.size());
  for (const Data& d : data_) angles.push_back(so3_log(X[d.frame].transpose() * d.A).norm());
  if (angles.empty()) return 0;
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

std::vector<Eigen::VectorXd> FrameEnergy::trust(const Frames& X, double robust_scale) const {
  std::vector<Eigen::VectorXd> trust;
  for (const int n : samples_) trust.push_back(Eigen::VectorXd::Ones(n));
  if (!(robust_scale > 0)) return trust;
  const double c2 = 2 * squared(robust_scale);
  for (const Data& d : data_) {
    const double t = c2 / (c2 + (X[d.frame] - d.A).squaredNorm());
    trust[d.curve][d.sample] = t * t;
  }
  return trust;
}

}  // namespace batten
