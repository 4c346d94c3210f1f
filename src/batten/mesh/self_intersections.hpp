#pragma once
#include <utility>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// How many pairs are listed where nobody asks for more.
inline constexpr std::size_t kMostListedIntersections = 1000;

/// Pairs of triangles (lower index first, sorted) that share more than the vertices and edges that they have
/// in common: crossing, touching, overlapping in a plane, folded back onto a neighbour, or equal. The test is
/// exact for the coordinates as given. Vertices at the same place count as one. Triangles without area are
/// left out. O(m log m) for the meshes of practice.
/// @param most how many pairs to list at most; the first ones in order.
/// @pre the indices are in range.
std::vector<std::pair<int, int>> self_intersections(const Points& positions, const Triangles& triangles,
                                                    size_t most = kMostListedIntersections,
                                                    const Progress& progress = {});

}  // namespace batten
