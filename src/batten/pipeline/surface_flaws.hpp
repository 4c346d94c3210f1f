#pragma once
#include <string>
#include <utility>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// What is known of a filled network before its flaws are told.
struct FilledPatches {
  const std::vector<int>& patch_of_triangle;               ///< one for each triangle
  const std::vector<char>& on_network;                     ///< one for each vertex: lies on a curve
  const std::vector<int>& folded;                          ///< triangles turned over, ascending
  const std::vector<std::pair<int, int>>& crossing_pairs;  ///< as of self_intersections()
};

/// Why a mesh is no surface of its curves, in words with patches and places; nothing for a sound one.
/// - Pairs of triangles cross; triangles are turned away from the propagated normals.
/// - A patch has collapsed: on more than a tenth of its area it stands at more than 60° to the normals that
///   its curves spread over it. Triangles with corners on curves alone do not count: at sharp curves their
///   normals are means of both sides.
/// - A patch leaves its curves: a vertex lies farther from the box around them than its diagonal is long.
/// @param mesh with propagated normals. Linear time.
/// @pre the sizes fit. Degrees of freedom that nothing determines (patches without inner vertices) are sound.
std::vector<std::string> surface_flaws(const TriangleMesh& mesh, const FilledPatches& patches);

}  // namespace batten
