// Regression on SO(3): S 3.5.4 with the corrections of docs/errata.md#s-3. The discrete energy is that of
// [boumal2013]; the solver is Newton's method with all second derivatives. Gauss–Newton, which leaves
// those of the residuals out, took hundreds of steps: agreement of the normals holds frames with a large
// force and a small residual, whose curvature is no smaller than that of the data, and the robust loss bends
// down where a residual is large, which a weighted sum of squares cannot follow.
#include "batten/scan/regression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/frame_energy_detail.hpp"
#include "batten/scan/turned_frames_detail.hpp"

namespace batten {

namespace {

void check_turns(const SampledScan& scan) {
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    for (int k = 0; k + 1 < curve.n_samples(); ++k) {
      // trace = 1 + 2 cos θ; a right angle has trace 1.
      const double trace = (curve.frames[k].transpose() * curve.frames[k + 1]).trace();
      if (trace <= 1)
        throw InvalidInput(concat("curve ", c + 1, ", at distance ", curve.parameters[k],
                                  ": the frame turns by ",
                                  "90° or more within one step; take a smaller step"));
    }
  }
}

/// Where a residual is this many standard deviations, the robust loss leaves a sample a quarter of its say.
constexpr double kRobustDeviations = 6;
/// The loss comes down to that in stages, so that the start does not decide which samples are trusted.
constexpr std::array<double, 2> kFirstDeviations{24, 12};
/// A stage before the last ends at turns below this (radians), or after so many steps.
constexpr double kStageTurn = 0.05;
constexpr int kSquareSteps = 4, kStageSteps = 2;
/// The scale of the loss follows the residuals until it has settled to this part of itself, or for so many
/// steps; then it is held, and the minimum is that of one energy.
constexpr double kScaleTolerance = 1e-6;
constexpr int kScaleSteps = 6;
/// The floor of the spread of the residuals keeps exact data: their residuals are what the smoothing takes
/// off, and none on straight pieces.
constexpr double kLeastSpread = radians(0.2);
/// follow() ends at turns below this (radians), or after so many steps.
constexpr double kFollowTurn = 0.02;
constexpr int kFollowSteps = 2;
/// Without damping and with the exact Hessian the error of a step is the square of that of the step before,
/// times a factor; below this turn (radians) the factor is taken from the last two steps.
constexpr double kQuadraticTurn = 0.1;

/// Scale of the robust loss at so many deviations of the residuals.
double robust_scale_of(const FrameEnergy& energy, const Frames& X, double deviations) {
  // Median of the length of a normal 3-vector: 1.538 σ.
  return deviations * std::max(energy.median_residual(X) / 1.538, kLeastSpread);
}

}  // namespace

/// Frames, scale and damping of one minimisation.
struct FrameRegression::State {
  explicit State(const SampledScan& scan)
      : energy(scan), system(energy.numbering().n_frames, energy.couplings()) {
    energy.bind(system);
  }

  double step(StageTimes& times, const Progress& progress);
  void approach(StageTimes& times, const Progress& progress);
  void settle_scale(StageTimes& times, const Progress& progress);
  bool converge(double tolerance, int max_iterations, StageTimes& times, const Progress& progress);
  void begin() {
    iterations = 0;
    damping = 0;
    stuck = false;
  }

  FrameEnergy energy;
  BlockSystem system;
  Frames X;
  double scale = 0;  ///< of the robust loss, radians; 0 for squares
  double damping = 0;
  bool stuck = false;   ///< no descent left within rounding
  bool newton = false;  ///< the last step was undamped, with all second derivatives
  int iterations = 0;
};

/// One step that lowers the energy: Newton's where its matrix is positive definite, else Gauss–Newton's;
/// damped after a step that raised the energy. @return the largest turn of a frame, radians.
double FrameRegression::State::step(StageTimes& times, const Progress& all) {
  constexpr double kFirstDamping = 1e-4, kNoDamping = 1e-9;
  constexpr int kTrials = 40;
  // Rounding of the sum; and a turn too small for the energy to show it.
  constexpr double kRounding = 1e-12, kSmallTurn = 1e-9;
  const double done = 0.1 * std::min(iterations, 9);
  const Progress progress = all.part("regression", done, done);
  const auto report = [&] { progress.report("regression", 0); };
  report();
  ++iterations;
  std::optional<ScopedStage> stage(std::in_place, times, "assembly");
  energy.assemble(X, scale, Curvature::Exact, system);
  report();
  newton = damping == 0;
  bool exact = true;
  const double before = energy.energies(X, scale).energy;
  Eigen::VectorXd delta;
  for (int trial = 0; trial < kTrials; ++trial) {
    stage.emplace(times, "factorisation");
    report();
    if (!system.solve(damping, delta, progress)) {
      newton = false;
      stage.emplace(times, "assembly");
      if (exact) energy.assemble(X, scale, Curvature::GaussNewton, system);
      if (!exact) damping = std::max(kFirstDamping, 10 * damping);
      exact = false;
      continue;
    }
    stage.emplace(times, "update");
    report();
    Frames next(X.size());
    double largest = 0;
    for (size_t f = 0; f < X.size(); ++f) {
      const Eigen::Vector3d d = delta.segment<3>(3 * static_cast<Eigen::Index>(f));
      largest = std::max(largest, d.norm());
      next[f] = X[f] * so3_exp(d);
    }
    const double after = energy.energies(next, scale).energy;
    if (after <= before * (1 + kRounding) || largest < kSmallTurn) {
      X.swap(next);
      damping = damping < 10 * kNoDamping ? 0 : 0.1 * damping;
      return largest;
    }
    newton = false;
    damping = damping == 0 ? kFirstDamping : 10 * damping;
  }
  stuck = true;
  return 0;
}

/// From the data towards the minimum of the robust energy: squares first, then ever narrower losses.
void FrameRegression::State::approach(StageTimes& times, const Progress& progress) {
  const auto stage = [&](int n_steps) {
    for (int i = 0; i < n_steps; ++i) {
      if (step(times, progress) < kStageTurn) break;
    }
  };
  scale = 0;
  stage(kSquareSteps);
  for (const double deviations : kFirstDeviations) {
    scale = robust_scale_of(energy, X, deviations);
    stage(kStageSteps);
  }
}

void FrameRegression::State::settle_scale(StageTimes& times, const Progress& progress) {
  for (int i = 0; i < kScaleSteps; ++i) {
    const double last = scale;
    scale = robust_scale_of(energy, X, kRobustDeviations);
    if (std::abs(scale - last) < kScaleTolerance * scale) break;
    step(times, progress);
  }
}

/// Steps until no frame turns by more than the tolerance. @return whether that was reached.
bool FrameRegression::State::converge(double tolerance, int max_iterations, StageTimes& times,
                                      const Progress& progress) {
  double last = 0;
  while (iterations < max_iterations) {
    const double turn = step(times, progress);
    if (stuck || turn < tolerance) return true;
    // The next turn would be about turn² · (turn/last²), and is not taken when that is below the tolerance.
    const bool quadratic = newton && last > 0 && last < kQuadraticTurn && turn < 0.1 * last;
    if (quadratic && turn * turn * std::max(1.0, turn / (last * last)) < tolerance) return true;
    last = newton ? turn : 0;
  }
  return false;
}

FrameRegression::FrameRegression(const SampledScan& scan)
    : scan_(turned_frames(scan)), state_(std::make_unique<State>(scan_)) {}
FrameRegression::~FrameRegression() = default;
FrameRegression::FrameRegression(FrameRegression&&) noexcept = default;
FrameRegression& FrameRegression::operator=(FrameRegression&&) noexcept = default;

void FrameRegression::set_frames(const SampledScan& scan) {
  for (size_t c = 0; c < scan.curves.size(); ++c)
    if (c >= scan_.curves.size() || scan.curves[c].n_samples() != scan_.curves[c].n_samples())
      throw InvalidInput("other frames for a kept regression must lie at the same samples");
  scan_ = turned_frames(scan);
  state_->energy.set_data(scan_);
}

void FrameRegression::begin(const RegressionOptions& options, StageTimes& times) {
  const ScopedStage setup(times, "setup");
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (options.mu > 0) check_turns(scan_);
  state_->energy.set_weights(options);
  state_->begin();
}

SampledScan FrameRegression::solve(const RegressionOptions& options, RegressionReport* report,
                                   const Progress& progress) {
  StageTimes times;
  begin(options, times);
  State& state = *state_;
  progress.report("regression", 0);
  state.X = state.energy.frames_of(scan_);
  state.scale = 0;
  if (options.robust) {
    state.approach(times, progress);
    state.settle_scale(times, progress);
  }
  const bool converged = state.converge(options.tolerance, options.max_iterations, times, progress);
  progress.report("regression", 1);
  return finish(converged, times, report);
}

void FrameRegression::start(const SampledScan& frames, double robust_scale) {
  state_->X = state_->energy.frames_of(frames);
  state_->scale = robust_scale;
}

SampledScan FrameRegression::follow(const RegressionOptions& options, RegressionReport* report,
                                    const Progress& progress) {
  State& state = *state_;
  if (state.X.empty()) return solve(options, report, progress);
  StageTimes times;
  begin(options, times);
  bool converged = false;
  for (int i = 0; i < kFollowSteps && !converged; ++i) {
    state.scale = options.robust ? robust_scale_of(state.energy, state.X, kRobustDeviations) : 0;
    converged = state.step(times, progress) < kFollowTurn;
  }
  return finish(converged, times, report);
}

SampledScan FrameRegression::finish(bool converged, const StageTimes& times, RegressionReport* report) const {
  const State& state = *state_;
  SampledScan smoothed = scan_;
  for (size_t c = 0; c < scan_.curves.size(); ++c)
    for (int k = 0; k < scan_.curves[c].n_samples(); ++k)
      smoothed.curves[c].frames[k] = nearest_rotation(state.X[state.energy.numbering().frames[c][k]]);
  if (report != nullptr) {
    *report = state.energy.energies(state.X, state.scale);
    report->converged = converged;
    report->iterations = state.iterations;
    report->robust_scale = state.scale;
    report->trust = state.energy.trust(state.X, state.scale);
    report->times = times;
  }
  return smoothed;
}

std::optional<std::string> RegressionOptions::problem() const {
  const auto negative = [](double value) { return !(value >= 0) || !std::isfinite(value); };
  if (negative(lambda)) return concat("lambda must be >= 0, got ", lambda);
  if (negative(mu)) return concat("mu must be >= 0, got ", mu);
  if (negative(xi)) return concat("xi must be >= 0, got ", xi);
  if (!(unit > 0) || !std::isfinite(unit)) return concat("unit must be > 0, got ", unit);
  if (max_iterations < 0) return concat("max_iterations must be >= 0, got ", max_iterations);
  if (negative(tolerance)) return concat("tolerance must be >= 0, got ", tolerance);
  return std::nullopt;
}

RegressionReport regression_energy(const SampledScan& scan, const SampledScan& frames,
                                   const RegressionOptions& options, double robust_scale) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  FrameEnergy energy(scan);
  energy.set_weights(options);
  return energy.energies(energy.frames_of(frames), robust_scale);
}

SampledScan regress_frames(const SampledScan& scan, const RegressionOptions& options,
                           RegressionReport* report, const Progress& progress) {
  return FrameRegression(scan).solve(options, report, progress);
}

}  // namespace batten
