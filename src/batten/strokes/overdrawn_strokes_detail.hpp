#pragma once
#include "batten/network/curve_network.hpp"

// Private to the room.
namespace batten::detail {

/// Drops what strokes repeat of longer ones, or of their own beginning: pieces that run along another one
/// within the tolerance and 25 degrees for at least six tolerances.
/// @param n_dropped is increased by the number of pieces.
CurveNetwork without_overdrawn(const CurveNetwork& network, double tolerance, int& n_dropped);

}  // namespace batten::detail
