// Quasi-Newton within a box: figures at a limit that the slope presses against are left out of a step.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/scan/noise_search_detail.hpp"

namespace batten {

namespace {

using Coordinates = NoisePrior::Coordinates;
using Curvature = Eigen::Matrix<double, NoisePrior::kFigures, NoisePrior::kFigures>;

constexpr int kMostSteps = 30, kMostTrials = 8;
/// A step changes no figure by more than this factor: the slopes say nothing about what lies further away.
constexpr double kMostFactor = 30;
/// What a search finds is rounded to this: half a percent of a figure or less, a hundredth of what the data
/// tell.
constexpr double kCoordinateGrid = 1.0 / 1024;
/// Part of the promised decrease that a step must bring (Armijo).
constexpr double kLeastDecrease = 1e-4;

Coordinates clamped(const Coordinates& u, const NoisePrior& prior) {
  return u.cwiseMax(prior.low()).cwiseMin(prior.high());
}

/// −B⁻¹ g over the figures that may move.
Coordinates quasi_newton_step(const NoisePrior& prior, const Coordinates& u, const Coordinates& g,
                              Curvature B) {
  Coordinates right = -g;
  for (int i = 0; i < NoisePrior::kFigures; ++i) {
    const bool held = (u[i] <= prior.low()[i] && g[i] >= 0) || (u[i] >= prior.high()[i] && g[i] <= 0);
    if (!held) continue;
    B.row(i).setZero();
    B.col(i).setZero();
    B(i, i) = 1;
    right[i] = 0;
  }
  Coordinates step = B.ldlt().solve(right);
  double largest = 0;
  for (int i = 0; i < NoisePrior::kFigures; ++i)
    largest = std::max(largest, std::abs(step[i]) * prior.scale(i));
  return step * std::min(1.0, std::log(kMostFactor) / std::max(largest, 1e-300));
}

/// B with its curvature along s replaced by that of the slopes; damped, so that it stays positive definite.
void update_curvature(Curvature& B, const Coordinates& s, Coordinates y) {
  const Coordinates Bs = B * s;
  const double sBs = s.dot(Bs), sy = s.dot(y);
  if (!(sBs > 0)) return;
  if (sy < 0.2 * sBs) {
    const double theta = 0.8 * sBs / (sBs - sy);
    y = theta * y + (1 - theta) * Bs;
  }
  B += y * y.transpose() / s.dot(y) - Bs * Bs.transpose() / sBs;
}

}  // namespace

NoiseSearch try_kinds(JointModel& model, const NoiseModel& start, const Progress& progress) {
  const NoisePrior& prior = model.prior();
  NoiseSearch best;
  best.noise = start;
  const auto evaluate = [&](const NoiseModel& noise) {
    const double done = best.evaluations++ / 13.0;
    progress.report("noise model", done);
    return model.evaluate(noise, false, progress.part("noise model", done, done)).evidence;
  };
  best.evidence = evaluate(start);
  for (const double bending : {0.01, 1.0, 100.0, 1e4}) {
    for (const double drift : {0.1, 0.5, 2.0}) {
      NoiseModel trial = start;
      trial.bending = bending;
      trial.drift = drift * start.white;
      const Coordinates u = prior.coordinates(trial);
      if (clamped(u, prior) != u) continue;
      const double evidence = evaluate(trial);
      if (evidence < best.evidence - 1e-3) best.evidence = evidence, best.noise = trial;
    }
  }
  return best;
}

NoiseSearch search_noise(JointModel& model, const NoiseModel& start, double tolerance,
                         const Progress& progress) {
  const NoisePrior& prior = model.prior();
  NoiseSearch search;
  Coordinates u = clamped(prior.coordinates(start), prior);
  const auto evaluate = [&](const Coordinates& at) {
    const double done = std::min(1.0, static_cast<double>(search.evaluations++) / kMostSteps);
    progress.report("noise model", done);
    return model.evaluate(prior.at(at), true, progress.part("noise model", done, done));
  };
  NoiseEvaluation here = evaluate(u);
  Curvature B = here.weight.asDiagonal();
  for (int i = 0; i < kMostSteps && !search.converged; ++i) {
    const Coordinates direction = quasi_newton_step(prior, u, here.slope, B);
    double length = 1;
    bool moved = false;
    for (int trial = 0; trial < kMostTrials && !moved; ++trial, length *= 0.4) {
      const Coordinates next = clamped(u + length * direction, prior), s = next - u;
      const double promised = -here.slope.dot(s);
      if (promised < tolerance) {
        search.converged = true;
        break;
      }
      NoiseEvaluation there;
      try {
        there = evaluate(next);
      } catch (const SolverFailure&) {
        continue;  // too far: no digits are left
      }
      moved = there.evidence < here.evidence - kLeastDecrease * promised;
      update_curvature(B, s, there.slope - here.slope);
      if (!moved) continue;
      u = next;
      here = there;
    }
    if (!moved) break;
  }
  // The search stops where the evidence is flat: the last digits of what it finds are rounding, which another
  // machine's sine and logarithm change, and they would reach every position. Rounded, the same noise comes
  // out everywhere.
  const Coordinates rounded = (u.array() / kCoordinateGrid).round() * kCoordinateGrid;
  search.noise = prior.at(clamped(rounded, prior));
  search.evidence = here.evidence;
  return search;
}

}  // namespace batten
