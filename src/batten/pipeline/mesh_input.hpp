#pragma once
#include <optional>
#include <string>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// What keeps a mesh from being processed, in words with the remedy, or nothing: no faces, numbers that are
/// not finite or out of the range in which squares and volumes can be computed, faces that name no vertex, no
/// area. The first thing that every request on a mesh asks; linear time.
std::optional<std::string> mesh_problem(const TriangleMesh& mesh);

/// "(x, y, z)" of a point, and of the middle of a triangle, for sentences that name a place.
std::string place_in_words(const Eigen::RowVector3d& point);
std::string place_in_words(const TriangleMesh& mesh, int triangle);

/// @throws InvalidInput with what mesh_problem() says.
void require_processable(const TriangleMesh& mesh);

}  // namespace batten
