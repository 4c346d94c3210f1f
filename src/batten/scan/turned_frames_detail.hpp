#pragma once
#include "batten/core/progress.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

/// The frames of a scan that its readings and the turns of its gyroscope make most probable, for regressions
/// that know nothing of a gyroscope: residuals log(A_k X_kᵀ) of the frames A_k, robustly, those of
/// JointTurns, and nothing about the shape. Drift and disturbances, behind which no turn of the device
/// stands, are left out. As it is where the scan has no turns (SampledCurve::turns) or where they do not fit
/// its frames. Gauss–Newton, some ten steps, linear in the samples. @throws SolverFailure, Cancelled.
SampledScan turned_frames(const SampledScan& scan, const Progress& progress = {});

}  // namespace batten
