#pragma once
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <Eigen/Core>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

using CgalMesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

inline CgalMesh to_cgal(const Points& positions, const Triangles& triangles) {
  CgalMesh result;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    result.add_vertex({positions(v, 0), positions(v, 1), positions(v, 2)});
  using Vertex = CgalMesh::Vertex_index;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    result.add_face(Vertex(triangles(f, 0)), Vertex(triangles(f, 1)), Vertex(triangles(f, 2)));
  return result;
}

/// Removes from `mesh` what is marked as deleted, since the numbers of the result have no gaps.
inline TriangleMesh from_cgal(CgalMesh& mesh) {
  mesh.collect_garbage();
  TriangleMesh result;
  result.positions.resize(mesh.number_of_vertices(), 3);
  result.triangles.resize(mesh.number_of_faces(), 3);
  Eigen::Index row = 0;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    result.positions.row(row++) << p.x(), p.y(), p.z();
  }
  row = 0;
  for (const auto f : mesh.faces()) {
    int k = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh))
      result.triangles(row, k++) = static_cast<int>(v);
    ++row;
  }
  return result;
}

}  // namespace batten
