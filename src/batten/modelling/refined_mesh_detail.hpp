#pragma once
#include <vector>

#include "batten/mesh/control_cage.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// What the surfaces of a model share; made in refined_mesh.cpp.
namespace batten::detail {

/// The quads as triangles, two by two, each cut by cut_along_corners().
Triangles cut_quads(const PolygonMesh& mesh);

/// The sharpness of a crease of the cage along a drawn edge of this sharpness: 0 to 1 for 0 to 4 levels, from
/// 1 infinite.
double crease_sharpness(double drawn);

/// Refuses a mesh of quads that folds, crosses itself, is not finite, or whose vertices on curves have left
/// `start` by more than a share of the size.
/// @param face_of_quad face of the model per quad. @param on_curve, start per vertex.
/// @throws InvalidInput naming the faces and the remedy.
void require_sound(const PolygonMesh& mesh, const std::vector<int>& face_of_quad,
                   const std::vector<char>& on_curve, const Points& start);

/// Turns closed components so that normals point outwards, by the sign of their volume.
void turn_outwards(const PolylineMesh& model, PolygonMesh& mesh, const std::vector<int>& face_of_quad);

}  // namespace batten::detail
