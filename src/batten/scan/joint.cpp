#include "batten/scan/joint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/joint_model_detail.hpp"
#include "batten/scan/noise_search_detail.hpp"
#include "batten/scan/regression.hpp"

namespace batten {

namespace {

/// How an estimate begins.
enum class JointStart {
  /// A light regression (half power at 15 % of the size) and its trust: what lies far from it has little say.
  Smooth,
  /// One that hardly smooths (1.5 %), and all samples trusted: for objects that turn so fast that the other
  /// takes
  /// their shape for a disturbance.
  Readings,
  /// The same, and all samples are trusted throughout.
  Trusting,
};

/// Frames and positions to begin with: a regression, integrated.
void start_from_regression(const SampledScan& scan, const JointOptions& options, JointStart start,
                           JointModel& model, const Progress& progress) {
  const bool smoothed = start == JointStart::Smooth;
  RegressionOptions regression;
  regression.unit = options.size;
  regression.mu = std::pow((smoothed ? 0.15 : 0.015) / (2 * kPi), 4);
  regression.xi = 100;
  regression.robust = options.robust && smoothed;
  regression.tolerance = 1e-6;
  // A smooth seam is one frame to the regression, which reads it once: from both ends alike, so that the
  // result does not depend on the direction of the curve.
  SampledScan data = scan;
  for (SampledCurve& curve : data.curves) {
    curve.turns.resize(0, 3);  // the gyroscope comes in with its errors, later
    if (curve.smooth_seam)
      curve.frames.front() = curve.frames.back() =
          nearest_rotation(curve.frames.front() + curve.frames.back());
  }
  RegressionReport report;
  const SampledScan smooth = regress_frames(data, regression, &report, progress);
  const JointLayout& layout = model.layout();
  JointState& state = model.state();
  for (int c = 0; c < layout.n_curves; ++c) {
    for (int k = scan.curves[c].n_samples() - 1; k >= 0; --k)
      state.X[layout.frames.frames[c][k]] = smooth.curves[c].frames[k];
    auto trust = state.trust.segment(layout.first_sample[c], scan.curves[c].n_samples());
    trust = report.trust[c];
    if (scan.curves[c].smooth_seam) trust[trust.size() - 1] = trust[0];
  }
  progress.report("regression", 1);
  const IntegrationResult placed =
      integrate_steps(smooth, frame_steps(smooth, StepRule::ConstantRate), ClosureForm::FirstDifference);
  state.nodes = placed.positions.topRows(layout.n_nodes) / options.size;
}

/// Noise model and state by turns: the first search is coarse because its linearisation is.
struct Round {
  double tolerance;  ///< of the evidence
  int most_steps;
};
constexpr Round kRounds[] = {{1.0, 3}, {0.2, 25}};
/// After so many steps of a round the changes of the rates of turn are held, and after so many the trust:
/// neither has derivatives, and single samples may go to and fro between two values of theirs for ever.
constexpr int kRateChangeSteps = 8, kTrustSteps = 16;
/// Turns below this (radians) are far below the noise of every device.
constexpr double kLeastTurn = 1e-6;
/// Below this turn steps that no longer shrink are rounding: dense samples make stiff systems.
constexpr double kRoundingTurn = 1e-4;

/// Parameters, factor and unevenness of a curve with the factors found.
void rescale(const JointModel& model, int c, SampledCurve& curve, JointEstimate& estimate) {
  const Eigen::VectorXd measured = curve.parameters;
  const double length = curve.length();
  double mean = 0, squares = 0;
  for (int k = 0; k + 1 < curve.n_samples(); ++k) {
    const double h = measured[k + 1] - measured[k];
    const double e = model.log_factor(model.layout().steps[model.layout().first_step[c] + k]);
    curve.parameters[k + 1] = curve.parameters[k] + std::exp(e) * h;
    mean += e * h / length;
    squares += e * e * h / length;
  }
  estimate.log_factors[c] = std::log(curve.length() / length);
  estimate.speed_spread[c] = std::sqrt(std::max(0.0, squares - mean * mean));
}

JointEstimate result_of(const SampledScan& scan, const JointModel& model) {
  const JointLayout& layout = model.layout();
  const JointState& state = model.state();
  JointEstimate estimate;
  estimate.scan = scan;
  estimate.log_factors.resize(layout.n_curves);
  estimate.speed_spread.resize(layout.n_curves);
  for (int c = 0; c < layout.n_curves; ++c) {
    SampledCurve& curve = estimate.scan.curves[c];
    const int n = curve.n_samples(), first = layout.first_sample[c];
    for (int k = 0; k < n; ++k)
      curve.frames[k] = nearest_rotation(state.X[layout.frame_of_sample[first + k]]);
    rescale(model, c, curve, estimate);
    estimate.drift.push_back(state.drift.middleRows(first, n));
    estimate.trust.push_back(state.trust.segment(first, n));
  }
  estimate.has_turns = !model.turns().empty();
  if (estimate.has_turns) {
    estimate.turn_density = model.turns().density();
    estimate.gyroscope_bias = model.turns().biases();
    estimate.gyroscope_matrix = model.turns().matrix();
  }
  return estimate;
}

/// The density of the gyroscope's noise of greatest evidence, from the least upwards.
void find_turn_density(JointModel& model, const NoiseModel& noise, int& evaluations,
                       const Progress& progress) {
  if (model.turns().empty()) return;
  double least = std::numeric_limits<double>::infinity(), best = kLeastTurnDensity;
  for (double density = kLeastTurnDensity; density <= kMostTurnDensity; density *= kTurnDensityFactor) {
    model.turns().set_density(density);
    const double evidence = model.evaluate(noise, false, progress).evidence;
    ++evaluations;
    if (evidence < least) least = evidence, best = density;
  }
  model.turns().set_density(best);
}

/// An estimate and what it costs, to be held against another of the same scan.
struct Attempt {
  JointEstimate estimate;
  double cost = 0;
};

Attempt attempt(const SampledScan& scan, const JointOptions& options, JointStart start, JointModel& model,
                const Progress& progress) {
  start_from_regression(scan, options, start, model, progress);
  NoiseModel noise = options.noise ? *options.noise : model.prior().centre();
  model.set_normal_deviation(noise.white);
  bool converged = false;
  int iterations = 0, evaluations = 0;
  double evidence = 0;
  const auto part = [&] {
    const double done = std::min(1.0, iterations / 15.0);
    progress.report("joint estimate", done);
    return progress.part("joint estimate", done, done);
  };
  for (const Round& round : kRounds) {
    model.linearize(part());
    if (!options.noise) {
      if (&round == kRounds) {
        if (!options.turn_density) find_turn_density(model, noise, evaluations, part());
        const NoiseSearch kinds = try_kinds(model, noise, progress);
        noise = kinds.noise;
        evaluations += kinds.evaluations;
      }
      const NoiseSearch search = search_noise(model, noise, round.tolerance, progress);
      noise = search.noise;
      evaluations += search.evaluations;
    }
    double last = 0;
    for (int i = 0; i < round.most_steps; ++i) {
      const NoiseEvaluation evaluation = model.evaluate(noise, false, part());
      evidence = evaluation.evidence;
      const double turn = model.apply(evaluation.step);
      ++iterations;
      ++evaluations;
      progress.report("joint estimate", std::min(1.0, iterations / 15.0));
      if (options.robust && start != JointStart::Trusting && i < kTrustSteps) model.update_trust(noise.white);
      converged = turn < kLeastTurn || (turn < kRoundingTurn && turn > last && last > 0);
      last = turn;
      if (converged) break;
      model.linearize(part(), i < kRateChangeSteps);
    }
  }
  Attempt result{result_of(scan, model), evidence + model.distrust_cost(noise.white)};
  JointEstimate& estimate = result.estimate;
  estimate.noise = noise;
  estimate.iterations = iterations;
  estimate.evaluations = evaluations;
  estimate.evidence = evidence;
  estimate.cost = result.cost;
  estimate.converged = converged;
  estimate.factor_deviation = model.factor_deviation(part());
  estimate.draws = posterior_draws(model, noise, options.n_draws, part());
  return result;
}

/// Above this share of its samples not trusted the shape of a curve may have been taken for a disturbance.
constexpr double kSuspiciousShare = 0.01;

/// Whether so many samples of a curve are not trusted that the start may be to blame.
bool ignores_much(const JointEstimate& estimate) {
  return std::any_of(estimate.trust.begin(), estimate.trust.end(), [](const Eigen::VectorXd& trust) {
    return static_cast<double>((trust.array() < 0.25).count()) >
           kSuspiciousShare * static_cast<double>(trust.size());
  });
}

}  // namespace

JointEstimate estimate_jointly(const SampledScan& scan, const JointOptions& options,
                               const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  JointModel model(scan, options, progress);
  Attempt best = attempt(scan, options, JointStart::Smooth, model, progress);
  if (!options.robust) return best.estimate;
  for (const JointStart start : {JointStart::Readings, JointStart::Trusting}) {
    if (!ignores_much(best.estimate)) break;
    try {
      model.reset();
      Attempt other = attempt(scan, options, start, model, progress);
      if (other.cost < best.cost) best = std::move(other);
    } catch (const SolverFailure&) {
      // The best so far stands.
    }
  }
  return best.estimate;
}

}  // namespace batten
