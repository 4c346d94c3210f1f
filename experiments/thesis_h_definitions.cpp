#include "thesis_h_definitions.hpp"

#include "thesis_h_tables.hpp"

#include <cmath>

#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/operators/mesh_variation.hpp"

namespace batten::experiments {

TriangleMesh midpoint_subdivided(const TriangleMesh& mesh) {
  const MeshEdges edges = mesh_edges(mesh.triangles, mesh.n_vertices());
  TriangleMesh result;
  result.positions.resize(mesh.n_vertices() + edges.n_edges(), 3);
  result.positions.topRows(mesh.n_vertices()) = mesh.positions;
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
    result.positions.row(mesh.n_vertices() + e) =
        (mesh.positions.row(edges.vertices(e, 0)) + mesh.positions.row(edges.vertices(e, 1))) / 2;
  result.triangles.resize(4 * mesh.n_triangles(), 3);
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Eigen::RowVector3i corner = mesh.triangles.row(f);
    const Eigen::RowVector3i middle = edges.of_triangle.row(f).array() + static_cast<int>(mesh.n_vertices());
    for (int k = 0; k < 3; ++k) result.triangles.row(4 * f + k) << corner[k], middle[k], middle[(k + 2) % 3];
    result.triangles.row(4 * f + 3) = middle;
  }
  return result;
}

double printed_diameter(const std::string& name, const TriangleMesh& mesh) {
  const double volume = enclosed_volume(mesh.positions, mesh.triangles);
  for (const MeshData& data : kTable21)
    if (data.mesh == name && volume > 0)
      return bounding_box_diagonal(mesh.positions) * std::cbrt(data.volume / volume);
  return 0;
}

double printed_area_variance(const TriangleMesh& original, const TriangleMesh& result) {
  const auto variance = [](const TriangleMesh& mesh) {
    const double area = face_areas(mesh.positions, mesh.triangles).sum();
    return area_variance(mesh.positions, mesh.triangles) * area * area /
           static_cast<double>(mesh.n_vertices());
  };
  const double before = variance(original);
  return std::abs(variance(result) - before) / before;
}

}  // namespace batten::experiments
