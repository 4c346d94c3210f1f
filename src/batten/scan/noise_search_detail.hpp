#pragma once
#include "batten/core/progress.hpp"
#include "batten/scan/joint_model_detail.hpp"

namespace batten {

/// How a search ended.
struct NoiseSearch {
  NoiseModel noise;
  double evidence = 0;
  int evaluations = 0;
  bool converged = false;  ///< the next step promised less than the tolerance
};

/// The best of a few kinds of objects and devices, or a search ends on a side peak.
NoiseSearch try_kinds(JointModel& model, const NoiseModel& start, const Progress& progress);

/// The noise model of least evidence for the linearised problem, by the BFGS method within the limits of
/// NoisePrior, with exact slopes.
/// @param tolerance of the evidence: below 1 nothing can be told apart.
NoiseSearch search_noise(JointModel& model, const NoiseModel& start, double tolerance,
                         const Progress& progress);

}  // namespace batten
