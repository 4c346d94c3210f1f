#pragma once
#include "batten/network/hermite.hpp"

namespace batten {

/// Samples every segment evenly by arc length along its Hermite spline, with a step as near to `step` as
/// divides the segment's length. Nodes, tagged nodes and corners keep their place and normal; the order and
/// direction of curves stay. Normals in between are interpolated on the sphere and kept perpendicular to the
/// tangent. Vertices that no curve uses are dropped.
/// @param step in the unit of the network, more than 0. A closed curve keeps three samples at least.
/// @throws InvalidInput as hermite_network(), when the step is not positive or would give more than 10⁸
/// samples.
CurveNetwork resampled(const CurveNetwork& network, double step, const HermiteOptions& options = {});

}  // namespace batten
