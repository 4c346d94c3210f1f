#pragma once
#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

/// Meshes cut into two tiles and joined again.
namespace batten::fixtures {

/// The triangles whose centre lies below (above, where `upper`) x = 0, with the vertices that they use.
inline TriangleMesh half_at_x0(const TriangleMesh& mesh, bool upper) {
  TriangleMesh half;
  std::vector<int> number(static_cast<std::size_t>(mesh.n_vertices()), -1), kept;
  std::vector<Eigen::RowVector3i> faces;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Eigen::RowVector3i t = mesh.triangles.row(f);
    const double x = mesh.positions(t[0], 0) + mesh.positions(t[1], 0) + mesh.positions(t[2], 0);
    if ((x > 0) != upper) continue;
    Eigen::RowVector3i face;
    for (int k = 0; k < 3; ++k) {
      if (number[t[k]] < 0) {
        number[t[k]] = static_cast<int>(kept.size());
        kept.push_back(t[k]);
      }
      face[k] = number[t[k]];
    }
    faces.push_back(face);
  }
  half.positions.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t v = 0; v < kept.size(); ++v)
    half.positions.row(static_cast<Eigen::Index>(v)) = mesh.positions.row(kept[v]);
  half.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) half.triangles.row(static_cast<Eigen::Index>(f)) = faces[f];
  return half;
}

/// Both meshes as one; vertices are the same where their three numbers are, to the last bit.
inline TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh;
  std::map<std::array<double, 3>, int> number;
  std::vector<std::array<double, 3>> points;
  mesh.triangles.resize(a.n_triangles() + b.n_triangles(), 3);
  Eigen::Index row = 0;
  for (const TriangleMesh* part : {&a, &b})
    for (Eigen::Index f = 0; f < part->n_triangles(); ++f, ++row)
      for (int k = 0; k < 3; ++k) {
        const auto p = part->positions.row(part->triangles(f, k));
        const std::array<double, 3> key{p.x(), p.y(), p.z()};
        const auto [found, is_new] = number.emplace(key, static_cast<int>(points.size()));
        if (is_new) points.push_back(key);
        mesh.triangles(row, k) = found->second;
      }
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    mesh.positions.row(static_cast<Eigen::Index>(v)) << points[v][0], points[v][1], points[v][2];
  return mesh;
}

/// The border edges of a mesh by the places of their ends, sorted.
inline std::vector<std::array<double, 6>> border_places(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> sides;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k) ++sides[{mesh.triangles(f, k), mesh.triangles(f, (k + 1) % 3)}];
  std::vector<std::array<double, 6>> places;
  for (const auto& [edge, count] : sides) {
    if (sides.count({edge.second, edge.first}) > 0) continue;
    const auto a = mesh.positions.row(edge.first), b = mesh.positions.row(edge.second);
    places.push_back({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()});
  }
  std::sort(places.begin(), places.end());
  return places;
}

}  // namespace batten::fixtures
