#pragma once
#include <vector>

#include "batten/core/arrays.hpp"

namespace batten {

/// A closed way over edges of a mesh that cannot be drawn together to a point on it: around a handle or
/// through it.
struct EssentialLoop {
  std::vector<int> vertices;  ///< in order; the last is joined to the first
  double length = 0;
};

/// Short essential loops, two per handle and root: those that the edges outside a tree of shortest ways and
/// its cotree close ([erickson2005]). Borders count as filled. The shorter first; several roots
/// may find the same. None on spheres and discs. O(n_roots · n log n).
/// @param triangles an oriented manifold. @param n_roots from which ways are sought, spread over the mesh;
/// the shortest loop is found where one of them lies on it, a longer one nearby else.
/// @throws InvalidInput where the triangles name vertices that are not there.
std::vector<EssentialLoop> essential_loops(const Points& positions, const Triangles& triangles,
                                           int n_roots = 32);

}  // namespace batten
