#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/network/curve_network.hpp"
#include "batten/surfacing/patch_detail.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::detail {

/// @throws InvalidInput where a surface cannot be asked for: options out of range, no curves, no normals,
/// numbers that are not finite.
void check_surface_input(const CurveNetwork& network, const SurfaceOptions& options);
/// @throws InvalidInput where there are no cycles, or one names a vertex that is not there.
void check_cycles(const std::vector<NetworkCycle>& cycles, const CurveNetwork& network);

/// @throws InvalidInput when all vertices lie at one place.
ScaledNetwork scaled_network(const CurveNetwork& network);

/// Positions and normals of a moved network in the units of an earlier one; normals as long as 1, or 0.
void rescale_network(const CurveNetwork& network, ScaledNetwork& scaled);

/// Samples crowded on a curve say little about the normals but much about their noise: two that differ by 5°
/// at a hundredth of the usual distance bend the propagated normals over in the whole patch. Of samples
/// closer than 0.3 of the mean step only the first keeps its normal, the others interpolate.
/// @return how many were changed.
int calm_crowded_normals(const CurveNetwork& network, ScaledNetwork& scaled);

/// Weights of soft constraints for n vertices, those of the network first: each vertex of a curve weighs as
/// much as the piece of curve that it stands for, in diameters, times `unit`; others of the network 1, or
/// their system would be singular.
Eigen::VectorXd soft_weights(const CurveNetwork& network, const ScaledNetwork& scaled, Eigen::Index n,
                             double unit);

/// Two vertices at one place make an edge of no length somewhere; says which before the mesher stumbles.
/// Where the cycles are given, that is so only of two in one cycle: others make a crease.
/// @throws InvalidInput naming both.
void check_coincident(const CurveNetwork& network, const ScaledNetwork& scaled,
                      const std::vector<NetworkCycle>& given);

}  // namespace batten::detail
