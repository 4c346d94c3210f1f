#pragma once
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// Which vertices of a mesh become one.
struct VertexWelding {
  std::vector<int> vertex_of;  ///< per vertex the one that stands for it; itself where nothing is welded
  Eigen::Index n_welded = 0;   ///< vertices that another one stands for
  double tolerance = 0;        ///< distance up to which vertices were welded, in the unit of the positions
};

/// Welds vertices on borders (of edges with one triangle) that lie within `tolerance` of each other; what
/// closes is never touched. Each vertex joins the nearest of those before it that stand for themselves, so
/// that no chain of welds moves anything further than the tolerance. O(n) for the meshes of practice.
/// @param tolerance at least 0; vertices at the same place are welded for every value.
/// @throws InvalidInput on an index out of range or a tolerance below 0.
VertexWelding weld_borders(const Points& positions, const Triangles& triangles, double tolerance);

/// The same with a tolerance that the mesh itself suggests: the smallest one after which a larger, up to
/// 1e-4 diameters, closes hardly anything more. Edges of triangles that would fold onto each other do not
/// count as closed, and no vertex is moved by more than a fifth of its shortest edge, so that nothing but
/// seams is welded.
VertexWelding weld_borders(const Points& positions, const Triangles& triangles);

/// True where most triangles stand alone, but at least half of their sides meet others once vertices are
/// welded: a mesh as STL files hold it.
/// @param welding of weld_borders() for this mesh.
bool is_triangle_soup(const Triangles& triangles, const VertexWelding& welding);

/// The triangles with welded vertices; those that come to name a vertex twice are left out.
Triangles welded_triangles(const Triangles& triangles, const VertexWelding& welding);

/// The mesh without the vertices that are marked; the others keep their order, normals and values.
/// @pre no triangle names one of them.
TriangleMesh without_vertices(const TriangleMesh& mesh, const std::vector<char>& gone);

/// One number for all vertices at exactly the same place: the lowest of them.
std::vector<int> places_of_vertices(const Points& positions);

}  // namespace batten
