#pragma once
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/surfacing/patch_detail.hpp"

namespace batten::detail {

/// Fills the loops of a cycle with triangles in space: loops joined by their shortest bridges, the polygon
/// triangulated with the least area turned away from the given normals (dynamic programming, after
/// [barequet1995] and [zou2013]), then refined to edges of about `edge` and made Delaunay [liepa2003].
/// @return false with half a sentence in `problem` where no manifold filling was found.
bool fill_loops(const Points& positions, const Points& normals, const NetworkCycle& cycle, double edge,
                PatchMesh& mesh, std::string& problem);

}  // namespace batten::detail
