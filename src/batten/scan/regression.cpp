// Regression on SO(3): S 3.5.4 with the corrections of docs/errata.md#s-3. The discrete energy is that of
// [boumal2013]; the solver is Gauss–Newton.
#include "batten/scan/regression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

/// Half-angle form of a relative rotation XᵀY: q = (v, w) with w ≥ 0, |v| = sin(θ/2).
struct HalfTurn {
  Eigen::Vector3d v;
  double w;
};

HalfTurn half_turn(const Eigen::Matrix3d& X, const Eigen::Matrix3d& Y) {
  const Eigen::Matrix3d R = X.transpose() * Y;
  const double trace = R.trace();
  if (trace > 0) {  // below 120°: every case but wild data
    const double w = 0.5 * std::sqrt(1 + trace);
    const double f = 0.25 / w;
    return {{f * (R(2, 1) - R(1, 2)), f * (R(0, 2) - R(2, 0)), f * (R(1, 0) - R(0, 1))}, w};
  }
  const Eigen::Quaterniond q(R);
  const double sign = q.w() < 0 ? -1 : 1;
  return {sign * q.vec(), sign * q.w()};
}

/// ‖X − Y‖²_F = 8 sin²(θ/2) as the square of three numbers, √8 v, with the derivatives for X exp(δ), Y
/// exp(ε): dv = −½(w I − v^) δ + ½(w I + v^) ε.
struct Chordal {
  Eigen::Vector3d r;
  Eigen::Matrix3d by_X, by_Y;
};

Chordal chordal(const Eigen::Matrix3d& X, const Eigen::Matrix3d& Y) {
  const double root8 = std::sqrt(8.0);
  const HalfTurn q = half_turn(X, Y);
  Chordal c;
  c.r = root8 * q.v;
  const Eigen::Matrix3d V = hat(q.v), W = q.w * Eigen::Matrix3d::Identity();
  c.by_X = -0.5 * root8 * (W - V);
  c.by_Y = 0.5 * root8 * (W + V);
  return c;
}

/// skew(XᵀY) as a vector, sin θ times the axis = 2 w v, with its derivatives.
struct Skew {
  Eigen::Vector3d s;
  Eigen::Matrix3d by_X, by_Y;
};

Skew skew(const Eigen::Matrix3d& X, const Eigen::Matrix3d& Y) {
  const HalfTurn q = half_turn(X, Y);
  Skew s;
  s.s = 2 * q.w * q.v;
  const Eigen::Matrix3d V = hat(q.v), W = q.w * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d outer = q.v * q.v.transpose();
  // d(2 w v) = 2 w dv + 2 v dw, dw = ½ vᵀδ for X and −½ vᵀε for Y.
  s.by_X = -q.w * (W - V) + outer;
  s.by_Y = q.w * (W + V) - outer;
  return s;
}

/// Terms of the energy over the unknown frames, with their weights for the chosen form.
struct Terms {
  struct Data {
    int frame;
    Eigen::Matrix3d A;
    double weight;
    int curve, sample;
  };
  struct Pair {
    int a, b;
    double weight;  ///< 1/h (lengths in the unit)
  };
  struct Triple {
    int before, at, after;
    double h_before, h_after;
    double weight;  ///< 2/(h_before + h_after)
  };
  std::vector<Data> data;
  std::vector<Pair> stretch;
  std::vector<Triple> bend;
  std::vector<std::pair<int, int>> normals;
  int n_frames = 0;
  double xi = 0, lambda = 0, mu = 0;
  double normal_weight = 1;  ///< h of the scaled form
  bool thesis = true;
};

Terms terms_of(const SampledScan& scan, const FrameNumbering& numbering, const RegressionOptions& options) {
  Terms terms;
  terms.n_frames = numbering.n_frames;
  terms.normals = numbering.node_pairs;
  terms.xi = options.xi;
  terms.lambda = options.lambda;
  terms.mu = options.mu;
  terms.thesis = options.energy == RegressionEnergy::Thesis;
  double length = 0;
  int n_steps = 0;
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    const SampledCurve& curve = scan.curves[c];
    const std::vector<int>& frames = numbering.frames[c];
    const int n = curve.n_samples();
    const bool ring = curve.smooth_seam;
    const auto h = [&](int k) { return curve.step(k) / options.unit; };
    for (int k = 0; k < n - 1; ++k) length += h(k), ++n_steps;
    for (int k = 0; k < (ring ? n - 1 : n); ++k) {
      // The length that the sample stands for: half of the steps on both sides.
      const double before = k > 0 ? h(k - 1) : (ring ? h(n - 2) : 0);
      const double after = k < n - 1 ? h(k) : 0;
      terms.data.push_back({frames[k], curve.frames[k], terms.thesis ? 1 : 0.5 * (before + after), c, k});
    }
    for (int k = 0; k < n - 1; ++k) terms.stretch.push_back({frames[k], frames[k + 1], 1 / h(k)});
    const auto bend = [&](int a, int b, int d, double h0, double h1) {
      terms.bend.push_back({a, b, d, h0, h1, 2 / (h0 + h1)});
    };
    for (int k = 1; k < n - 1; ++k) bend(frames[k - 1], frames[k], frames[k + 1], h(k - 1), h(k));
    if (ring && n > 2) bend(frames[n - 2], frames[0], frames[1], h(n - 2), h(0));
  }
  if (!terms.thesis && n_steps > 0) terms.normal_weight = length / n_steps;
  return terms;
}

using Frames = std::vector<Eigen::Matrix3d>;

/// Energies of S (3.27, 3.29) and their weighted sum; `trust` scales the data terms.
RegressionReport energies(const Terms& terms, const Frames& X, double robust_scale) {
  RegressionReport report;
  double data = 0;
  for (const Terms::Data& d : terms.data) {
    const double e = (X[d.frame] - d.A).squaredNorm();
    report.E_0 += d.weight * e;
    if (robust_scale > 0) {
      // Geman–McClure: ρ = c² e/(c² + e), e ≈ 2θ², c² = 2 (radians)².
      const double c2 = 2 * robust_scale * robust_scale;
      data += d.weight * c2 * e / (c2 + e);
    } else {
      data += d.weight * e;
    }
  }
  for (const Terms::Pair& p : terms.stretch) report.E_1 += p.weight * (X[p.a] - X[p.b]).squaredNorm();
  for (const Terms::Triple& t : terms.bend) {
    const Eigen::Vector3d r =
        skew(X[t.at], X[t.after]).s / t.h_after + skew(X[t.at], X[t.before]).s / t.h_before;
    report.E_2 += t.weight * 2 * r.squaredNorm();  // ‖a^‖²_F = 2‖a‖²
  }
  for (const auto& [i, j] : terms.normals) report.E_N += (X[i].col(1) - X[j].col(1)).squaredNorm();
  report.energy =
      terms.normal_weight * terms.xi * report.E_N + data + terms.lambda * report.E_1 + terms.mu * report.E_2;
  return report;
}

/// Normal equations with 3 × 3 blocks on a pattern found once.
class BlockSystem {
 public:
  BlockSystem(const Terms& terms) : solver_("regression of the frames") {
    const int n = terms.n_frames;
    std::vector<std::vector<int>> below(n);  // block rows under the diagonal, per block column
    const auto join = [&](int a, int b) {
      if (a != b) below[std::min(a, b)].push_back(std::max(a, b));
    };
    for (const Terms::Pair& p : terms.stretch) join(p.a, p.b);
    for (const Terms::Triple& t : terms.bend) {
      join(t.before, t.at);
      join(t.at, t.after);
      join(t.before, t.after);
    }
    for (const auto& [i, j] : terms.normals) join(i, j);
    H_.resize(3 * n, 3 * n);
    first_block_.assign(n + 1, 0);
    for (int j = 0; j < n; ++j) {
      std::sort(below[j].begin(), below[j].end());
      below[j].erase(std::unique(below[j].begin(), below[j].end()), below[j].end());
      first_block_[j + 1] = first_block_[j] + static_cast<int>(below[j].size()) + 1;
    }
    rows_.resize(first_block_[n]);
    Eigen::Index nonzeros = 9 * static_cast<Eigen::Index>(first_block_[n]);
    H_.resizeNonZeros(nonzeros);
    int* outer = H_.outerIndexPtr();
    int* inner = H_.innerIndexPtr();
    outer[0] = 0;
    for (int j = 0; j < n; ++j) {
      rows_[first_block_[j]] = j;
      std::copy(below[j].begin(), below[j].end(), rows_.begin() + first_block_[j] + 1);
      const int n_blocks = first_block_[j + 1] - first_block_[j];
      for (int c = 0; c < 3; ++c) {
        int* column = inner + outer[3 * j + c];
        for (int b = 0; b < n_blocks; ++b)
          for (int r = 0; r < 3; ++r) column[3 * b + r] = 3 * rows_[first_block_[j] + b] + r;
        outer[3 * j + c + 1] = outer[3 * j + c] + 3 * n_blocks;
      }
    }
    clear();
  }

  void clear() {
    std::fill(H_.valuePtr(), H_.valuePtr() + H_.nonZeros(), 0.0);
    gradient_.setZero(H_.rows());
  }

  /// Adds w ‖r + Σ J_i δ_i‖² over up to three distinct frames.
  template <size_t K, typename Residual>
  void add(double w, const Residual& r, const std::array<int, K>& frames,
           const std::array<Eigen::Matrix3d, K>& J) {
    for (size_t a = 0; a < K; ++a) {
      gradient_.segment<3>(3 * frames[a]) += w * J[a].transpose() * r;
      for (size_t b = 0; b < K; ++b) {
        if (frames[a] < frames[b]) continue;
        // A ring of two steps meets itself: both products fall on one block, which then sums up rightly.
        add_block(frames[a], frames[b], w * J[a].transpose() * J[b]);
      }
    }
  }

  /// Solves (H + damping·diag H) δ = −gradient.
  Eigen::VectorXd solve(double damping) {
    SparseMatrix& H = H_;
    std::vector<double> diagonal;
    if (damping > 0) {
      for (Eigen::Index i = 0; i < H.rows(); ++i) {
        double& d = H.valuePtr()[H.outerIndexPtr()[i] + i % 3];
        diagonal.push_back(d);
        d *= 1 + damping;
      }
    }
    solver_.factorize(H);
    for (size_t i = 0; i < diagonal.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      H.valuePtr()[H.outerIndexPtr()[k] + k % 3] = diagonal[i];
    }
    return -solver_.solve(gradient_);
  }

 private:
  void add_block(int row, int column, const Eigen::Matrix3d& block) {
    const int first = first_block_[column], end = first_block_[column + 1];
    int b = first;
    while (rows_[b] != row) ++b;  // a handful of blocks, except at nodes
    const int stride = 3 * (end - first);
    double* place = H_.valuePtr() + H_.outerIndexPtr()[3 * column] + 3 * (b - first);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) place[c * stride + r] += block(r, c);
  }

  SparseMatrix H_;
  Eigen::VectorXd gradient_;
  std::vector<int> first_block_, rows_;
  SparseCholesky solver_;
};

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void check(const SampledScan& scan, const RegressionOptions& options) {
  const auto negative = [](const char* name, double value) {
    if (!(value >= 0) || !std::isfinite(value))
      throw InvalidInput(concat("the weight ", name, " must be >= 0, got ", value));
  };
  negative("lambda", options.lambda);
  negative("mu", options.mu);
  negative("xi", options.xi);
  if (!(options.unit > 0)) throw InvalidInput(concat("the unit of length must be > 0, got ", options.unit));
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    for (int k = 0; k + 1 < curve.n_samples(); ++k) {
      // trace = 1 + 2 cos θ; a right angle has trace 1.
      const double trace = (curve.frames[k].transpose() * curve.frames[k + 1]).trace();
      if (options.mu > 0 && trace <= 1)
        throw InvalidInput(concat("curve ", c + 1, ", at distance ", curve.parameters[k],
                                  ": the frame turns by ",
                                  "90° or more within one step; take a smaller step"));
    }
  }
}

}  // namespace

RegressionReport regression_energy(const SampledScan& scan, const SampledScan& frames,
                                   const RegressionOptions& options) {
  const FrameNumbering numbering = number_frames(scan);
  const Terms terms = terms_of(scan, numbering, options);
  Frames X(numbering.n_frames);
  for (size_t c = 0; c < scan.curves.size(); ++c)
    for (int k = scan.curves[c].n_samples() - 1; k >= 0; --k)
      X[numbering.frames[c][k]] = frames.curves[c].frames[k];
  return energies(terms, X, 0);
}

SampledScan regress_frames(const SampledScan& scan, const RegressionOptions& options,
                           RegressionReport* report, const Progress& progress) {
  StageTimes times;
  std::optional<ScopedStage> setup(std::in_place, times, "setup");
  check(scan, options);
  const FrameNumbering numbering = number_frames(scan);
  const Terms terms = terms_of(scan, numbering, options);
  Frames X(numbering.n_frames, Eigen::Matrix3d::Identity());
  for (size_t c = 0; c < scan.curves.size(); ++c)
    for (int k = scan.curves[c].n_samples() - 1; k >= 0; --k)
      X[numbering.frames[c][k]] = scan.curves[c].frames[k];

  BlockSystem system(terms);
  setup.reset();
  const Eigen::Matrix3d normal_by_turn = -hat(Eigen::Vector3d::UnitY());  // d(X e₂) = X (δ × e₂)
  // Robust loss: first the square, then Geman–McClure with a scale that comes down to three times the spread
  // of the residuals, so that the start does not decide which samples are trusted.
  double scale = 0;
  const int n_rounds = options.robust ? 6 : 1;
  RegressionReport result;
  for (int round = 0; round < n_rounds; ++round) {
    if (round > 0) {
      std::vector<double> residuals;
      for (const Terms::Data& d : terms.data)
        residuals.push_back(so3_log(X[d.frame].transpose() * d.A).norm());
      // Median of the length of a normal 3-vector: 1.538 σ. The floor keeps exact data: their residuals are
      // what the smoothing takes off, and none on straight pieces.
      const double sigma = std::max(median_of(residuals) / 1.538, radians(0.2));
      const double factor = round == 1 ? 24 : round == 2 ? 12 : 6;
      scale = factor * sigma;
    }
    double damping = 0;
    double energy = energies(terms, X, scale).energy;
    result.converged = false;
    for (int i = 0; i < options.max_iterations && !result.converged; ++i) {
      progress.report("regression", std::min(1.0, (round + i / 10.0) / n_rounds));
      std::optional<ScopedStage> assembly(std::in_place, times, "assembly");
      system.clear();
      for (const Terms::Data& d : terms.data) {
        const Chordal c = chordal(X[d.frame], d.A);
        double weight = d.weight;
        if (scale > 0) {
          const double c2 = 2 * scale * scale, t = c2 / (c2 + c.r.squaredNorm());
          weight *= t * t;
        }
        system.add<1>(weight, c.r, {d.frame}, {c.by_X});
      }
      if (terms.lambda > 0)
        for (const Terms::Pair& p : terms.stretch) {
          const Chordal c = chordal(X[p.a], X[p.b]);
          system.add<2>(terms.lambda * p.weight, c.r, {p.a, p.b}, {c.by_X, c.by_Y});
        }
      if (terms.mu > 0)
        for (const Terms::Triple& t : terms.bend) {
          const Skew after = skew(X[t.at], X[t.after]), before = skew(X[t.at], X[t.before]);
          const Eigen::Vector3d r = after.s / t.h_after + before.s / t.h_before;
          system.add<3>(2 * terms.mu * t.weight, r, {t.before, t.at, t.after},
                        {Eigen::Matrix3d(before.by_Y / t.h_before),
                         Eigen::Matrix3d(after.by_X / t.h_after + before.by_X / t.h_before),
                         Eigen::Matrix3d(after.by_Y / t.h_after)});
        }
      if (terms.xi > 0)
        for (const auto& [a, b] : terms.normals)
          system.add<2>(terms.normal_weight * terms.xi, Eigen::Vector3d(X[a].col(1) - X[b].col(1)), {a, b},
                        {Eigen::Matrix3d(X[a] * normal_by_turn), Eigen::Matrix3d(-X[b] * normal_by_turn)});
      assembly.reset();
      ++result.iterations;
      // Full Gauss–Newton steps; damped only after a step that raised the energy.
      for (int trial = 0;; ++trial) {
        std::optional<ScopedStage> stage(std::in_place, times, "factorisation");
        const Eigen::VectorXd delta = system.solve(damping);
        stage.emplace(times, "update");
        Frames next(X.size());
        double largest = 0;
        for (size_t f = 0; f < X.size(); ++f) {
          const Eigen::Vector3d d = delta.segment<3>(3 * static_cast<Eigen::Index>(f));
          largest = std::max(largest, d.norm());
          next[f] = X[f] * so3_exp(d);
        }
        const double next_energy = energies(terms, next, scale).energy;
        if (next_energy <= energy * (1 + 1e-12) || largest < 1e-9) {
          X.swap(next);
          energy = next_energy;
          damping *= 0.1;
          if (damping < 1e-9) damping = 0;
          result.converged = largest < options.tolerance;
          break;
        }
        if (trial == 30) {  // no descent left within rounding
          result.converged = true;
          break;
        }
        damping = damping == 0 ? 1e-4 : 10 * damping;
      }
    }
  }
  SampledScan smoothed = scan;
  for (size_t c = 0; c < scan.curves.size(); ++c)
    for (int k = 0; k < scan.curves[c].n_samples(); ++k)
      smoothed.curves[c].frames[k] = nearest_rotation(X[numbering.frames[c][k]]);
  if (report != nullptr) {
    const bool converged = result.converged;
    const int iterations = result.iterations;
    *report = energies(terms, X, scale);
    report->converged = converged;
    report->iterations = iterations;
    report->robust_scale = scale;
    report->times = times;
    report->trust.resize(scan.curves.size());
    for (size_t c = 0; c < scan.curves.size(); ++c)
      report->trust[c] = Eigen::VectorXd::Ones(scan.curves[c].n_samples());
    if (scale > 0) {
      for (const Terms::Data& d : terms.data) {
        const double c2 = 2 * scale * scale;
        const double t = c2 / (c2 + (X[d.frame] - d.A).squaredNorm());
        report->trust[d.curve][d.sample] = t * t;
      }
    }
  }
  return smoothed;
}

}  // namespace batten
