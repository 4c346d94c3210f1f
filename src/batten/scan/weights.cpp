#include "batten/scan/weights.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/text.hpp"

namespace batten {

namespace {

double mean_step(const SampledScan& scan) {
  int n = 0;
  for (const SampledCurve& curve : scan.curves) n += curve.n_samples() - 1;
  return scan.length() / n;
}

}  // namespace

RegressionWeights weights_of(const NoiseModel& noise, double readings_per_sample) {
  RegressionWeights weights;
  const double variance = noise.white * noise.white / std::max(readings_per_sample, 1e-3);
  weights.lambda = variance / noise.stretch;
  weights.mu = variance / noise.bending;
  weights.reason = "from the noise model";
  return weights;
}

RegressionWeights choose_weights(const SampledScan& scan, double size, const RegressionOptions& given,
                                 StepRule rule, ClosureForm form, const NoiseModel* noise,
                                 const Progress& progress) {
  RegressionOptions options = given;
  options.unit = size;
  const double h = mean_step(scan) / size;
  const double factor = options.energy == RegressionEnergy::Scaled ? h : 1;
  FrameRegression regression(scan);
  const auto network = [&](double lambda, double mu) {
    options.lambda = factor * lambda;
    options.mu = factor * mu;
    const SampledScan smooth = regression.solve(options, nullptr, progress);
    return integrate_steps(smooth, frame_steps(smooth, rule), form);
  };
  double readings = 0;
  for (const SampledCurve& curve : scan.curves) readings += curve.weights.sum();
  RegressionWeights best;
  const IntegrationResult unfiltered = integrate_steps(scan, frame_steps(scan, rule), form);
  if (unfiltered.n_loops == 0) {
    if (noise != nullptr) best = weights_of(*noise, readings / scan.n_samples());
    best.reason = "the network has no loops to close: from the noise of the readings";
    best.lambda *= factor, best.mu *= factor;
    return best;
  }
  double least = std::numeric_limits<double>::infinity();
  int done = 0;
  for (const double lambda : {0.0, 0.01, 0.1, 1.0, 10.0}) {
    for (const double mu : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0}) {
      progress.report("weights", done++ / 35.0);
      const IntegrationResult result = network(lambda, mu);
      if (result.closure_energy < least) {
        least = result.closure_energy;
        best.lambda = factor * lambda, best.mu = factor * mu;
        best.closure_misfit = result.closure_misfit;
      }
    }
  }
  best.reason = concat("of 35 pairs the one whose network closes best, to ", best.closure_misfit);
  return best;
}

}  // namespace batten
