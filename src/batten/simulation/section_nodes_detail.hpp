#pragma once
#include <vector>

#include "batten/simulation/traced_curve.hpp"

// Where traced curves meet. Private to the room.
namespace batten::detail {

/// Where a curve passes through the zeros of `cut`: distances along the curve, ascending. Zeros that are
/// nearer together than `step` may be missed, in pairs.
/// @param tolerance zeros nearer than this are one, and an end of an open curve so near to `cut` is a zero.
std::vector<double> passages(const ArcLengthCurve& path, bool closed, const ImplicitFunction& cut,
                             double step, double tolerance);

/// Finds the nodes of a network: points where two curves pass through each other's cuts. Closed curves are
/// made to begin at a node.
/// @param cuts of every curve the surface, beside `surface`, on which it lies.
void find_nodes(TracedNetwork& traced, const std::vector<ImplicitFunction>& cuts,
                const ImplicitFunction& surface);

}  // namespace batten::detail
