#pragma once
#include <cstddef>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/remeshing/connectivity.hpp"

namespace batten {

/// Takes away crossings of the triangles of `state` where the reference, which it is to follow, has none:
/// step by step around the triangles that cross, vertices are evened out within the surface, then put on it,
/// then triangles cut in two. Only steps after which fewer pairs cross stay, save cuts, of which some are
/// needed before it gets better; in the end the state with the fewest is kept. Vertices on features stay on
/// them. Costs nothing but one search where nothing crosses.
/// @param allowed pairs that may stay: those of the reference. @return pairs that still cross. @throws
/// Cancelled.
std::size_t mend_crossings(RemeshState& state, const Points& reference_positions,
                           const Triangles& reference_triangles, std::size_t allowed,
                           const Progress& progress = {});

}  // namespace batten
