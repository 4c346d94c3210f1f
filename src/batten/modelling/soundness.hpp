#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// What is broken in a finished surface of a model, and where.
struct SurfaceSoundness {
  std::size_t crossing_pairs = 0;  ///< pairs of triangles that cross; counted up to kMostCrossingPairs
  std::size_t turned_triangles = 0;
  std::vector<int> broken_faces;  ///< faces of the model that hold such triangles, ascending

  bool is_sound() const { return broken_faces.empty(); }
  /// One sentence with the faces and the remedy. @pre not sound.
  std::string sentence() const;
};

/// Pairs of crossing triangles beyond this number are not counted.
constexpr std::size_t kMostCrossingPairs = 100000;

/// Finds triangles that cross and names the faces of the model that hold them or a turned one.
/// @param turned triangles against the normals of the surface, ascending.
/// @param face_of_triangle face of the model, per triangle.
/// Cost: a search in a box tree, O(n log n) for n triangles.
SurfaceSoundness surface_soundness(const TriangleMesh& mesh, const std::vector<int>& turned,
                                   const std::vector<int>& face_of_triangle);

/// Triangles against the normals of the mesh, ascending. Normals of vertices on creases, means of both sides,
/// do not count: where the sides meet at a sharp angle, sound triangles lie against them.
/// @param on_crease per vertex.
std::vector<int> turned_triangles(const TriangleMesh& mesh, const std::vector<char>& on_crease);

}  // namespace batten
