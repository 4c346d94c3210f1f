#pragma once
#include <string>

#include "batten/core/progress.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/joint.hpp"
#include "batten/scan/regression.hpp"

namespace batten {

/// λ and μ for regress_frames() and what they rest on.
struct RegressionWeights {
  double lambda = 0, mu = 0;
  double closure_misfit = 0;  ///< of the network that they give, in the unit of the scan; 0 without loops
  std::string reason;         ///< in words
};

/// Chooses λ and μ of the plain regression (no drift, no length factors) from the data: of the pairs
/// λ ∈ {0, 0.01, 0.1, 1, 10} × μ ∈ {1e-6 … 1 by decades} (lengths in sizes, thesis energy) the one whose
/// network closes best in the least-squares sense. Slow drift looks like signal to every criterion that sees
/// the orientations alone; closure does not. Networks without loops take the weights that the noise model of
/// estimate_jointly() stands for, weights_of().
/// @param options energy, ξ and robust loss are taken from here; λ, μ and unit are replaced.
RegressionWeights choose_weights(const SampledScan& scan, double size, const RegressionOptions& options,
                                 StepRule rule, ClosureForm form, const NoiseModel* noise = nullptr,
                                 const Progress& progress = {});

/// The weights of the thesis energy (lengths in sizes) that a noise model stands for: λ = σ²/stretch,
/// μ = σ²/bending, with σ² the variance of one sample.
RegressionWeights weights_of(const NoiseModel& noise, double readings_per_sample);

/// The same smoothing in the other energy: λ' = λ h, μ' = μ h (docs/methods.md#regression), h the mean step
/// in sizes.
inline double scaled_weight(double thesis_weight, double step) {
  return thesis_weight * step;
}

}  // namespace batten
