#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/scan/samples.hpp"

namespace batten {

/// How the rate of turn changes along one curve: per sample the derivative of ω, in axes of the frames, by
/// central differences; at an end that of the next sample.
/// @param omega per step, rate of turn. @param lengths per step. @param ring the last sample is the first.
/// Changes by more than half a radian from step to step count as such: there is a corner.
std::vector<Eigen::Vector3d> rate_changes(const std::vector<Eigen::Vector3d>& omega,
                                          const std::vector<double>& lengths, bool ring);

/// What a rate of turn that changes by ω' adds to a step of length h from the frame X that turns by φ:
/// −h³/12 · X exp(φ/2) (ω' × e₁), the next term of ∫ exp(θ(u)) e₁ du with θ(u) = φ u + ω' h² (u² − u)/2.
/// Steps are of fourth order with it.
Eigen::Vector3d step_of_rate_change(const Eigen::Matrix3d& X, const Eigen::Vector3d& phi, double h,
                                    const Eigen::Vector3d& rate_change);

/// Takes the lag of the pre-filter (SampledCurve::lag) off the frames: X ← X exp(−lag ω').
void remove_lag(SampledScan& scan);

}  // namespace batten
