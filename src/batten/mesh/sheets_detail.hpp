#pragma once
#include <array>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/mesh/mending.hpp"

namespace batten::detail {

/// The vertices of a mesh while it is mended: where each comes from. One vertex, or the middle of two.
using Origins = std::vector<std::array<int, 2>>;

/// Steps 4 to 6 of mended_mesh(): cuts a mesh into sheets that are manifold and oriented. Added vertices are
/// appended to positions and origins.
/// @pre no triangle names a vertex twice, and no two the same three places.
void cut_into_sheets(Points& positions, Triangles& triangles, Origins& origins, bool orient,
                     MendingReport& report, const Progress& progress);

}  // namespace batten::detail
