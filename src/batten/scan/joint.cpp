#include "batten/scan/joint.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/regression.hpp"

namespace batten {

namespace {

/// Relative slip of the odometer that no factor explains, as a random walk: 1e-4 sizes over one size. It also
/// takes up the error of the steps between samples, and keeps the system well conditioned.
constexpr double kSlip = 1e-4;
/// Precision of the mean log factor: that of a length known to 10⁻⁵.
constexpr double kCommonScale = 1e10;
/// No device is better (0.006°); below, the error of the steps between samples would pass for noise.
constexpr double kLeastNoise = 1e-4;
/// Rows whose weight does not depend on the noise model, and the groups whose weight does.
enum Group { kFixed, kWhite, kScale, kStretch, kBending, kJerk, kGroups };

/// One residual of three components, linear in a few blocks of unknowns.
struct Row {
  int group = kFixed;
  double weight = 1;
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  int n_blocks = 0;
  std::array<int, 5> offset{};
  std::array<int, 5> width{};
  std::array<Eigen::Matrix3d, 5> J{};

  void block(int at, const Eigen::Matrix3d& derivative) {
    offset[n_blocks] = at, width[n_blocks] = 3, J[n_blocks++] = derivative;
  }
  void column(int at, const Eigen::Vector3d& derivative) {
    offset[n_blocks] = at, width[n_blocks] = 1, J[n_blocks].col(0) = derivative, ++n_blocks;
  }
};

/// Two neighbouring samples of a curve, in the drift process.
struct DriftStep {
  int before, after;  ///< sample numbers
  double length;      ///< in sizes
};

struct Evaluation {
  double evidence = 0;
  Eigen::VectorXd step;
};

class JointModel {
 public:
  JointModel(const SampledScan& scan, const JointOptions& options)
      : scan_(scan), options_(options), vertices_(number_vertices(scan)), frames_(number_frames(scan)) {
    n_curves_ = static_cast<int>(scan.curves.size());
    for (const SampledCurve& curve : scan.curves) {
      first_sample_.push_back(n_samples_);
      for (int k = 0; k + 1 < curve.n_samples(); ++k)
        drift_steps_.push_back({n_samples_ + k, n_samples_ + k + 1, curve.step(k) / options.size});
      n_samples_ += curve.n_samples();
    }
    // Unknowns, along the curves in their order: what the fill-reducing ordering finds easiest.
    frame_at_ = 0;
    drift_at_ = frame_at_ + 3 * frames_.n_frames;
    position_at_ = drift_at_ + 3 * n_samples_;
    scale_at_ = position_at_ + 3 * vertices_.n_vertices;
    n_unknowns_ = scale_at_ + n_curves_;
    X_.assign(frames_.n_frames, Eigen::Matrix3d::Identity());
    b_.setZero(n_samples_, 3);
    x_.setZero(vertices_.n_vertices, 3);
    e_.setZero(n_curves_);
    length_share_.resize(n_curves_);
    for (int c = 0; c < n_curves_; ++c) length_share_[c] = scan.curves[c].length();
    length_share_ /= length_share_.sum();
    trust_.setOnes(n_samples_);
    start();
  }

  NoiseModel& noise() { return noise_; }
  int iterations() const { return iterations_; }
  int evaluations() const { return evaluations_; }

  /// Residuals and derivatives at the present state, gathered per group on one sparse pattern.
  void linearize() {
    rows_.clear();
    add_data();
    add_shape();
    add_normals();
    add_positions();
    add_scales();
    if (H_.nonZeros() == 0) build_pattern();
    gather();
  }

  /// −2 log marginal likelihood of a noise model for the linearised problem, and the step to its optimum.
  Evaluation evaluate(const NoiseModel& noise) {
    ++evaluations_;
    const std::array<double, kGroups> weights{1,
                                              1 / (noise.white * noise.white),
                                              1 / (noise.scale * noise.scale),
                                              1 / noise.stretch,
                                              1 / noise.bending,
                                              1 / noise.jerk};
    double constant = 0;
    Eigen::Map<Eigen::VectorXd> values(H_.valuePtr(), H_.nonZeros());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n_unknowns_);
    values.setZero();
    for (int g = 0; g < kGroups; ++g) {
      values += weights[g] * group_values_[g];
      gradient += weights[g] * group_gradient_[g];
      constant += weights[g] * group_constant_[g];
    }
    // The scale all curves share is not observable, yet a network that shrinks as a whole closes ever better:
    // the mean of the log factors, weighted by length, is held at 0.
    const double common = length_share_.dot(e_);
    size_t entry = 0;
    for (int i = 0; i < n_curves_; ++i) {
      gradient[scale_at_ + i] += kCommonScale * common * length_share_[i];
      for (int j = 0; j <= i; ++j)
        values[scale_slots_[entry++]] += kCommonScale * length_share_[i] * length_share_[j];
    }
    constant += kCommonScale * common * common;
    double log_determinants =
        3.0 * n_data_ * std::log(noise.white * noise.white) + n_curves_ * std::log(noise.scale * noise.scale);
    log_determinants -= 3 * log_determinant_of_shape(noise);
    // Ornstein–Uhlenbeck: b_0 ~ N(0, σ²), b_{k+1} | b_k ~ N(φ b_k, σ²(1 − φ²)), φ = exp(−h/ℓ).
    const double variance = noise.drift * noise.drift;
    const auto add_drift = [&](int sample, double precision) {
      for (int a = 0; a < 3; ++a) {
        H_.valuePtr()[drift_diagonal_[3 * sample + a]] += precision;
        gradient[drift_at_ + 3 * sample + a] += precision * b_(sample, a);
        constant += precision * b_(sample, a) * b_(sample, a);
      }
    };
    for (const int first : first_sample_) {
      add_drift(first, 1 / variance);
      log_determinants += 3 * std::log(variance);
    }
    for (size_t i = 0; i < drift_steps_.size(); ++i) {
      const DriftStep& s = drift_steps_[i];
      const double phi = std::exp(-s.length / noise.drift_length);
      const double innovation = -variance * std::expm1(-2 * s.length / noise.drift_length);
      const double w = 1 / innovation;
      log_determinants += 3 * std::log(innovation);
      for (int a = 0; a < 3; ++a) {
        const double r = b_(s.after, a) - phi * b_(s.before, a);
        H_.valuePtr()[drift_diagonal_[3 * s.after + a]] += w;
        H_.valuePtr()[drift_diagonal_[3 * s.before + a]] += w * phi * phi;
        H_.valuePtr()[drift_lower_[3 * i + a]] -= w * phi;
        gradient[drift_at_ + 3 * s.after + a] += w * r;
        gradient[drift_at_ + 3 * s.before + a] -= w * phi * r;
        constant += w * r * r;
      }
    }
    if (!analyzed_) {
      factor_.analyzePattern(H_);
      analyzed_ = true;
    }
    factor_.factorize(H_);
    Evaluation result;
    if (factor_.info() != Eigen::Success || !(factor_.vectorD().minCoeff() > 0))
      throw SolverFailure("joint estimate of frames and positions", n_unknowns_);
    result.step = -factor_.solve(gradient);
    const double energy = constant + gradient.dot(result.step);
    result.evidence = energy + factor_.vectorD().array().log().sum() + log_determinants + prior(noise);
    if (!std::isfinite(result.evidence))
      throw SolverFailure("joint estimate of frames and positions", n_unknowns_);
    return result;
  }

  /// Moves the state. @return the largest turn of a frame, radians.
  double apply(const Eigen::VectorXd& step) {
    ++iterations_;
    double largest = 0;
    for (int f = 0; f < frames_.n_frames; ++f) {
      const Eigen::Vector3d d = step.segment<3>(frame_at_ + 3 * f);
      largest = std::max(largest, d.norm());
      X_[f] = so3_exp(d) * X_[f];
    }
    for (int i = 0; i < n_samples_; ++i) b_.row(i) += step.segment<3>(drift_at_ + 3 * i).transpose();
    for (int v = 0; v < vertices_.n_vertices; ++v)
      x_.row(v) += step.segment<3>(position_at_ + 3 * v).transpose();
    e_ += step.segment(scale_at_, n_curves_);
    return largest;
  }

  /// Weights of the robust loss: 1 up to four standard deviations, then falling as the fourth power of the
  /// residual. Below one degree nothing is distrusted: with exact data that would be the error of the steps.
  void update_trust() {
    constexpr double kDeviations = 4, kLeast = radians(1.0);
    for (int c = 0; c < n_curves_; ++c) {
      for (int k = 0; k < scan_.curves[c].n_samples(); ++k) {
        const int i = first_sample_[c] + k;
        const double m = scan_.curves[c].weights[k];
        const Eigen::Vector3d r = data_residual(c, k);
        const double limit = std::max(kDeviations * noise_.white / std::sqrt(std::max(m, 1.0)), kLeast);
        const double ratio = limit * limit / std::max(r.squaredNorm(), 1e-300);
        trust_[i] = ratio >= 1 ? 1 : ratio * ratio;
      }
    }
  }

  JointEstimate result() {
    JointEstimate estimate;
    estimate.scan = scan_;
    estimate.noise = noise_;
    estimate.iterations = iterations_;
    estimate.evaluations = evaluations_;
    estimate.log_factors = e_;
    for (int c = 0; c < n_curves_; ++c) {
      SampledCurve& curve = estimate.scan.curves[c];
      const int n = curve.n_samples();
      for (int k = 0; k < n; ++k) curve.frames[k] = nearest_rotation(X_[frames_.frames[c][k]]);
      curve.parameters *= std::exp(e_[c]);
      estimate.drift.push_back(b_.middleRows(first_sample_[c], n));
      estimate.trust.push_back(trust_.segment(first_sample_[c], n));
    }
    return estimate;
  }

  /// Posterior deviations of the factors about their mean. @pre evaluate() has just been called.
  Eigen::VectorXd factor_deviation() {
    // One curve at a time: all at once would be a dense matrix of unknowns × curves.
    Eigen::VectorXd deviations(n_curves_), right = Eigen::VectorXd::Zero(n_unknowns_);
    for (int c = 0; c < n_curves_; ++c) {
      right.segment(scale_at_, n_curves_).setConstant(-1.0 / n_curves_);
      right[scale_at_ + c] += 1;
      const Eigen::VectorXd solution = factor_.solve(right);
      deviations[c] = std::sqrt(right.dot(solution));
    }
    return deviations;
  }

 private:
  /// Frames to begin with: a light regression; positions from their integration.
  void start() {
    RegressionOptions options;
    options.unit = options_.size;
    options.mu = std::pow(0.15 / (2 * kPi), 4);  // half power at 15 % of the size
    options.xi = 100;
    options.robust = options_.robust;
    options.tolerance = 1e-6;
    RegressionReport report;
    const SampledScan smooth = regress_frames(scan_, options, &report);
    for (int c = 0; c < n_curves_; ++c) {
      for (int k = scan_.curves[c].n_samples() - 1; k >= 0; --k)
        X_[frames_.frames[c][k]] = smooth.curves[c].frames[k];
      trust_.segment(first_sample_[c], scan_.curves[c].n_samples()) = report.trust[c];
    }
    const IntegrationResult placed =
        integrate_steps(smooth, frame_steps(smooth, StepRule::ConstantRate), ClosureForm::FirstDifference);
    x_ = placed.positions / options_.size;
    noise_.white = std::max(options_.reading_noise, kLeastNoise);
    noise_.drift = 0.5 * noise_.white;
    noise_.drift_length = 0.2;
    noise_.scale = options_.scale_deviation > 0 ? options_.scale_deviation : 0.003;
    noise_.stretch = 100;
    noise_.bending = 10;
    noise_.jerk = 1e4;
    start_noise_ = noise_;
    if (options_.noise) noise_ = *options_.noise;
    normal_deviation_ = noise_.white * std::sqrt(2 / std::max(options_.xi, 1e-6));
  }

  /// Weak priors of the noise model, −2 log: what devices are like. Two thirds within the factors given.
  double prior(const NoiseModel& n) const {
    const auto about = [](double value, double centre, double factor) {
      const double u = std::log(value / centre) / std::log(factor);
      return u * u;
    };
    return about(n.white, start_noise_.white, 1.5) + about(n.drift, start_noise_.drift, 2) +
           about(n.drift_length, 0.2, 2) + about(n.scale, start_noise_.scale, 3) + about(n.bending, 10, 100) +
           about(n.stretch, 100, 100) + about(n.jerk, 1e4, 1000);
  }

  Eigen::Vector3d data_residual(int c, int k) const {
    const Eigen::Matrix3d& X = X_[frames_.frames[c][k]];
    return so3_log(scan_.curves[c].frames[k] * X.transpose()) - b_.row(first_sample_[c] + k).transpose();
  }

  void add_data() {
    n_data_ = 0;
    for (int c = 0; c < n_curves_; ++c) {
      for (int k = 0; k < scan_.curves[c].n_samples(); ++k) {
        const int f = frames_.frames[c][k], i = first_sample_[c] + k;
        const double m = scan_.curves[c].weights[k] * trust_[i];
        if (m <= 0) continue;
        ++n_data_;
        const Eigen::Vector3d l = so3_log(scan_.curves[c].frames[k] * X_[f].transpose());
        Row row{kWhite, m, l - b_.row(i).transpose()};
        // log(A Xᵀ exp(−η)) ≈ l − J_r⁻¹(l) η for X ← exp(η) X
        row.block(frame_at_ + 3 * f, -so3_right_jacobian_inverse(l));
        row.block(drift_at_ + 3 * i, -Eigen::Matrix3d::Identity());
        rows_.push_back(row);
      }
    }
  }

  /// The prior of the shape: ω = log(X_kᵀ X_{k+1})/h on every step, its first and second differences, each as
  /// an integral along the curve. On scalars in place of ω the same rows make `shape_`.
  void add_shape() {
    const bool first = shape_.nonZeros() == 0;
    std::array<std::vector<Eigen::Triplet<double>>, 3> scalar;
    int at = 0;
    for (int c = 0; c < n_curves_; ++c) {
      const SampledCurve& curve = scan_.curves[c];
      const std::vector<int>& frame = frames_.frames[c];
      const int n = curve.n_samples() - 1;  // steps
      const bool ring = curve.smooth_seam && n >= 4;
      std::vector<Eigen::Vector3d> omega(n);
      std::vector<Eigen::Matrix3d> D(n);
      std::vector<double> h(n);
      for (int k = 0; k < n; ++k) {
        const Eigen::Matrix3d &X = X_[frame[k]], &Y = X_[frame[k + 1]];
        h[k] = curve.step(k) / options_.size;
        const Eigen::Vector3d u = so3_log(X.transpose() * Y);
        omega[k] = u / h[k];
        // log(Xᵀ exp(η' − η) Y) ≈ u + J_r⁻¹(u) Yᵀ (η' − η)
        D[k] = so3_right_jacobian_inverse(u) * Y.transpose() / h[k];
      }
      // A combination of neighbouring ω: coefficients for steps `begin`, `begin` + 1, …
      const auto add = [&](int group, double weight, int begin, const std::vector<double>& coefficients) {
        const int m = static_cast<int>(coefficients.size());
        Row row;
        row.group = group;
        row.weight = weight;
        row.r.setZero();
        Eigen::Matrix3d carried = Eigen::Matrix3d::Zero();
        for (int i = 0; i < m; ++i) {
          const int k = (begin + i) % n;
          const double a = coefficients[i];
          row.r += a * omega[k];
          row.block(frame_at_ + 3 * frame[k], carried - a * D[k]);
          carried = a * D[k];
        }
        row.block(frame_at_ + 3 * frame[(begin + m - 1) % n + 1], carried);
        rows_.push_back(row);
        if (!first) return;
        for (int i = 0; i < m; ++i)
          for (int j = 0; j < m; ++j) {
            const int a = at + (begin + i) % n, b = at + (begin + j) % n;
            if (a >= b)
              scalar[group - kStretch].emplace_back(a, b, weight * coefficients[i] * coefficients[j]);
          }
      };
      const auto between = [&](int k) { return 0.5 * (h[k % n] + h[(k + 1) % n]); };
      for (int k = 0; k < n; ++k) add(kStretch, h[k], k, {1});
      for (int k = 0; k + 1 < (ring ? n + 1 : n); ++k) add(kBending, 1 / between(k), k, {-1, 1});
      for (int k = 0; k + 2 < (ring ? n + 2 : n); ++k) {
        const double a = 1 / between(k), b = 1 / between(k + 1);
        add(kJerk, 2 / (between(k) + between(k + 1)), k, {a, -a - b, b});
      }
      at += n;
    }
    if (!first) return;
    std::vector<Eigen::Triplet<double>> pattern;
    for (const auto& entries : scalar)
      for (const Eigen::Triplet<double>& e : entries) pattern.emplace_back(e.row(), e.col(), 0.0);
    shape_.resize(at, at);
    shape_.setFromTriplets(pattern.begin(), pattern.end());
    for (int g = 0; g < 3; ++g) {
      SparseMatrix M = shape_;
      for (const Eigen::Triplet<double>& e : scalar[g]) M.coeffRef(e.row(), e.col()) += e.value();
      shape_values_[g] = Eigen::Map<Eigen::VectorXd>(M.valuePtr(), M.nonZeros());
    }
    shape_factor_.analyzePattern(shape_);
  }

  /// log det of the precision of ω, per component.
  double log_determinant_of_shape(const NoiseModel& noise) {
    Eigen::Map<Eigen::VectorXd>(shape_.valuePtr(), shape_.nonZeros()) =
        shape_values_[0] / noise.stretch + shape_values_[1] / noise.bending + shape_values_[2] / noise.jerk;
    shape_factor_.factorize(shape_);
    return shape_factor_.vectorD().array().log().sum();
  }

  void add_normals() {
    for (const auto& [i, j] : frames_.node_pairs) {
      const Eigen::Vector3d a = X_[i].col(1), b = X_[j].col(1);
      Row row{kFixed, 1 / (normal_deviation_ * normal_deviation_), a - b};
      row.block(frame_at_ + 3 * i, -hat(a));
      row.block(frame_at_ + 3 * j, hat(b));
      rows_.push_back(row);
    }
  }

  void add_positions() {
    for (int c = 0; c < n_curves_; ++c) {
      const SampledCurve& curve = scan_.curves[c];
      for (int k = 0; k + 1 < curve.n_samples(); ++k) {
        const int f0 = frames_.frames[c][k], f1 = frames_.frames[c][k + 1];
        const int v0 = vertices_.vertices[c][k], v1 = vertices_.vertices[c][k + 1];
        const double h = curve.step(k) / options_.size * std::exp(e_[c]);
        const Eigen::Vector3d phi = so3_log(X_[f0].transpose() * X_[f1]);
        const Eigen::Vector3d d = h * (X_[f0] * so3_right_jacobian(-phi).col(0));
        // The tangent at u is turned by (1 − u) η + u η'; Simpson's rule over the step gives the derivative.
        const Eigen::Vector3d t0 = h * X_[f0].col(0), t1 = h * X_[f1].col(0);
        const Eigen::Vector3d tm = h * (X_[f0] * so3_exp(0.5 * phi)).col(0);
        Row row{kFixed, options_.size / (kSlip * kSlip * curve.step(k)),
                (x_.row(v1) - x_.row(v0)).transpose() - d};
        row.block(position_at_ + 3 * v1, Eigen::Matrix3d::Identity());
        row.block(position_at_ + 3 * v0, -Eigen::Matrix3d::Identity());
        row.block(frame_at_ + 3 * f0, hat(t0 + 2 * tm) / 6);
        row.block(frame_at_ + 3 * f1, hat(2 * tm + t1) / 6);
        row.column(scale_at_ + c, -d);
        rows_.push_back(row);
      }
    }
    // The place of the whole is free: hold vertex 0 where it is.
    Row row{kFixed, 1, Eigen::Vector3d::Zero()};
    row.block(position_at_, Eigen::Matrix3d::Identity());
    rows_.push_back(row);
  }

  void add_scales() {
    for (int c = 0; c < n_curves_; ++c) {
      Row row{kScale, 1, Eigen::Vector3d(e_[c], 0, 0)};
      row.column(scale_at_ + c, Eigen::Vector3d::UnitX());
      rows_.push_back(row);
    }
  }

  /// Lower triangle, found from the first linearisation; later ones have the same blocks.
  void build_pattern() {
    std::vector<Eigen::Triplet<double>> entries;
    const auto touch = [&](int i, int j) { entries.emplace_back(std::max(i, j), std::min(i, j), 0.0); };
    for (int u = 0; u < n_unknowns_; ++u) touch(u, u);
    for (const Row& row : rows_)
      for (int a = 0; a < row.n_blocks; ++a)
        for (int b = 0; b <= a; ++b)
          for (int i = 0; i < row.width[a]; ++i)
            for (int j = 0; j < row.width[b]; ++j) touch(row.offset[a] + i, row.offset[b] + j);
    for (int i = 0; i < n_curves_; ++i)
      for (int j = 0; j < i; ++j) touch(scale_at_ + i, scale_at_ + j);
    // Samples without readings have no data row; their drift and frame still share the chain.
    for (const DriftStep& s : drift_steps_)
      for (int a = 0; a < 3; ++a) touch(drift_at_ + 3 * s.before + a, drift_at_ + 3 * s.after + a);
    H_.resize(n_unknowns_, n_unknowns_);
    H_.setFromTriplets(entries.begin(), entries.end());
    H_.makeCompressed();
    for (int i = 0; i < n_curves_; ++i)
      for (int j = 0; j <= i; ++j) scale_slots_.push_back(slot(scale_at_ + i, scale_at_ + j));
    for (int i = 0; i < 3 * n_samples_; ++i) drift_diagonal_.push_back(slot(drift_at_ + i, drift_at_ + i));
    for (const DriftStep& s : drift_steps_)
      for (int a = 0; a < 3; ++a)
        drift_lower_.push_back(slot(drift_at_ + 3 * s.after + a, drift_at_ + 3 * s.before + a));
  }

  Eigen::Index slot(int row, int column) const {
    const int* begin = H_.innerIndexPtr() + H_.outerIndexPtr()[column];
    const int* end = H_.innerIndexPtr() + H_.outerIndexPtr()[column + 1];
    return std::lower_bound(begin, end, row) - H_.innerIndexPtr();
  }

  void gather() {
    for (int g = 0; g < kGroups; ++g) {
      group_values_[g].setZero(H_.nonZeros());
      group_gradient_[g].setZero(n_unknowns_);
      group_constant_[g] = 0;
    }
    for (const Row& row : rows_) {
      Eigen::VectorXd& values = group_values_[row.group];
      group_constant_[row.group] += row.weight * row.r.squaredNorm();
      for (int a = 0; a < row.n_blocks; ++a) {
        const Eigen::Vector3d g = row.weight * (row.J[a].transpose() * row.r);
        for (int i = 0; i < row.width[a]; ++i) group_gradient_[row.group][row.offset[a] + i] += g[i];
        for (int b = 0; b < row.n_blocks; ++b) {
          if (row.offset[b] > row.offset[a]) continue;
          const Eigen::Matrix3d block = row.weight * (row.J[a].transpose() * row.J[b]);
          // Blocks lie whole within columns, rows of one block follow each other.
          for (int j = 0; j < row.width[b]; ++j) {
            const int first = row.offset[a] == row.offset[b] ? j : 0;
            Eigen::Index place = slot(row.offset[a] + first, row.offset[b] + j);
            for (int i = first; i < row.width[a]; ++i) values[place++] += block(i, j);
          }
        }
      }
    }
  }

  const SampledScan& scan_;
  JointOptions options_;
  VertexNumbering vertices_;
  FrameNumbering frames_;
  int n_curves_ = 0, n_samples_ = 0, n_unknowns_ = 0, n_data_ = 0;
  int frame_at_ = 0, drift_at_ = 0, position_at_ = 0, scale_at_ = 0;
  std::vector<int> first_sample_;
  std::vector<DriftStep> drift_steps_;

  std::vector<Eigen::Matrix3d> X_;
  Points b_, x_;  ///< drift per sample; positions in sizes
  Eigen::VectorXd e_, trust_;
  Eigen::VectorXd length_share_;  ///< of each curve in the length of all
  NoiseModel noise_, start_noise_;
  double normal_deviation_ = 0;

  std::vector<Row> rows_;
  SparseMatrix H_;
  std::vector<Eigen::Index> drift_diagonal_, drift_lower_, scale_slots_;
  std::array<Eigen::VectorXd, kGroups> group_values_, group_gradient_;
  std::array<double, kGroups> group_constant_{};
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> factor_;
  SparseMatrix shape_;
  std::array<Eigen::VectorXd, 3> shape_values_;
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> shape_factor_;
  bool analyzed_ = false;
  int iterations_ = 0, evaluations_ = 0;
};

/// Pattern search over the logarithms of the noise model, on a fixed grid so that rounding cannot move the
/// result. Besides the figures one by one it tries the pairs that the data tell apart worst.
void search_noise(JointModel& model, const JointOptions& options, double first_step, double last_step,
                  const Progress& progress) {
  NoiseModel& noise = model.noise();
  // Exponents of: white, drift, drift length, bending, jerk, stretch, scale.
  using Move = std::array<double, 7>;
  std::vector<Move> moves{
      {0, 0, 0, 3, 0, 0, 0},    // bending
      {0, 1, 0, 0, 0, 0, 0},    // drift
      {0, 0, 1, 0, 0, 0, 0},    // drift length
      {0, 1, 2, 0, 0, 0, 0},    // both, at one rate of change
      {0, -1, 0, 2, 0, 0, 0},   // slow drift against shape
      {0, 0, -1, 2, 0, 0, 0},   //
      {0.5, 0, 0, 0, 0, 0, 0},  // white
      {0, 0, 0, 0, 3, 0, 0},    // jerk
      {0, 0, 0, 3, -3, 0, 0},   // one kind of smoothness against another
      {0, 0, 0, 0, 0, 2, 0},    // stretch
  };
  if (options.scale_deviation <= 0) moves.push_back({0, 0, 0, 0, 0, 0, 1});
  const auto moved = [](NoiseModel n, const Move& move, double step) {
    const std::array<double*, 7> figures{&n.white, &n.drift,   &n.drift_length, &n.bending,
                                         &n.jerk,  &n.stretch, &n.scale};
    for (size_t i = 0; i < figures.size(); ++i) *figures[i] *= std::exp2(step * move[i]);
    return n;
  };
  // No device drifts by tens of degrees, and no odometer is wrong by a tenth: a model that says so explains
  // the shape as noise.
  const double white =
      std::max(options.reading_noise, kLeastNoise);  // from neighbours: right within a factor
  const double most_drift = std::max(radians(3), 4 * white);
  const double most_scale = std::max(0.02, options.scale_deviation);
  const auto in_range = [&](const NoiseModel& n) {
    return n.white >= std::max(kLeastNoise, white / 3) && n.white <= 3 * white &&
           n.drift >= 0.1 * kLeastNoise && n.drift <= most_drift && n.drift_length >= 0.01 &&
           n.drift_length <= 2 && n.scale >= 1e-6 && n.scale <= most_scale && n.bending >= 1e-4 &&
           n.bending <= 1e8 && n.jerk >= 1e-3 && n.jerk <= 1e10 && n.stretch >= 1e-3 && n.stretch <= 1e6;
  };
  double best = model.evaluate(noise).evidence;
  if (first_step > last_step) {
    // The search starts from the best of a few kinds of objects and devices, or it ends on a side peak.
    const NoiseModel start = noise;
    for (const double bending : {0.01, 1.0, 100.0, 1e4}) {
      for (const double drift : {0.1, 0.5, 2.0}) {
        NoiseModel trial = start;
        trial.bending = bending;
        trial.drift = drift * start.white;
        const double value = in_range(trial) ? model.evaluate(trial).evidence : best;
        if (value < best - 1e-3) best = value, noise = trial;
      }
    }
  }
  for (double step = first_step; step >= 0.99 * last_step; step *= 0.5) {
    for (int sweep = 0; sweep < 10; ++sweep) {
      progress.report("noise model", 0.1 * sweep);
      const double before = best;
      for (const Move& move : moves) {
        for (const double sign : {1.0, -1.0}) {
          bool improved = false;
          while (true) {
            const NoiseModel trial = moved(noise, move, sign * step);
            const double value = in_range(trial) ? model.evaluate(trial).evidence : best;
            if (!(value < best - 1e-3)) break;
            best = value;
            noise = trial;
            improved = true;
          }
          if (improved) break;  // the other way was worse
        }
      }
      if (before - best < 0.1) break;
    }
  }
}

}  // namespace

JointEstimate estimate_jointly(const SampledScan& scan, const JointOptions& options,
                               const Progress& progress) {
  if (!(options.size > 0)) throw InvalidInput(concat("the size of the scan must be > 0, got ", options.size));
  JointModel model(scan, options);
  // Noise model and state by turns: the first search is coarse because its linearisation is.
  double evidence = 0;
  for (int round = 0; round < 2; ++round) {
    model.linearize();
    if (!options.noise) search_noise(model, options, round == 0 ? 2 : 0.5, round == 0 ? 1 : 0.5, progress);
    const int n_steps = round == 0 ? 3 : 12;
    for (int i = 0; i < n_steps; ++i) {
      progress.report("joint estimate", (round * 3 + i) / 15.0);
      const Evaluation evaluation = model.evaluate(model.noise());
      evidence = evaluation.evidence;
      const double turn = model.apply(evaluation.step);
      if (options.robust) model.update_trust();
      if (turn < 1e-9) break;
      model.linearize();
    }
  }
  model.evaluate(model.noise());
  JointEstimate estimate = model.result();
  estimate.evidence = evidence;
  estimate.factor_deviation = model.factor_deviation();
  return estimate;
}

}  // namespace batten
