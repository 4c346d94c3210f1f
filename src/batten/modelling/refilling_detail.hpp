#pragma once
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

// Faces of a finished surface that came out folded are filled anew. Private to the room.
namespace batten::detail {

/// How the inside of a face is placed, its curves held.
enum class Refill {
  Plate,     ///< a thin plate that leaves its smooth curves as its neighbours arrive there
  Membrane,  ///< the surface of the least area, or near it: meets its neighbours in creases
};

/// Places the inner vertices of some faces anew and the normals of all their vertices; triangles stay. Linear
/// systems of as many unknowns as there are inner vertices, one for a plate and some for its membrane.
/// @param face_of_triangle face of the model per triangle. @param on_crease per vertex.
void refill_faces(TriangleMesh& mesh, const std::vector<int>& face_of_triangle, const std::vector<int>& faces,
                  const std::vector<char>& on_crease, Refill how);

}  // namespace batten::detail
