#pragma once
#include <vector>

#include "batten/core/arrays.hpp"

namespace batten::detail {

/// Evens out the triangles of a solved surface, in space: their layouts in the plane stretch where patches
/// bend over, and needles stay there. Around triangles of less than 15° that curves do not force, edges flip
/// where that makes the smallest angle of both triangles larger, and inner vertices move in their tangent
/// planes towards the area-weighted mean of the circumcentres around them [chen2004], where that is for the
/// better; curves, and edges between vertices of curves, stay. The positions are those of a surface to solve
/// for again: a moved vertex leaves it by its curvature.
/// @param X n × 3, moved. @param N n × 3 unit normals. @param T changed; patches keep their triangles.
/// @param on_network per vertex.
/// @return whether anything was changed. Linear time.
bool relax_triangles(Points& X, const Points& N, Triangles& T, const std::vector<char>& on_network);

/// How many triangles have an angle below 15° that is not one between two edges of curves.
int count_needles(const Points& X, const Triangles& T, const std::vector<char>& on_network);

}  // namespace batten::detail
