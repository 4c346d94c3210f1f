#pragma once
#include "mesh/shapes.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/triangle_mesh.hpp"

// Surfaces with edges that the tests of the room share.
namespace batten::fixtures {

/// A roof: two planes that meet in a ridge along y at x = 0.46.
inline Eigen::Vector3d roof(double u, double v) {
  return {u, v, 0.15 * std::min(u / 0.46, (1 - u) / 0.54)};
}

inline TriangleMesh grid_of(int m, Eigen::Vector3d (*surface)(double, double)) {
  return fixtures::as_mesh(fixtures::grid(m, m, false, false, surface));
}

/// The surface of the unit cube, every face a grid of n × n squares, welded.
inline TriangleMesh cube(int n) {
  std::map<std::array<int, 3>, int> numbers;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> faces;
  const auto vertex = [&](std::array<int, 3> key) {
    const auto [at, is_new] = numbers.emplace(key, static_cast<int>(points.size()));
    if (is_new) points.emplace_back(key[0] / double(n), key[1] / double(n), key[2] / double(n));
    return at->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int a, int b) {
            std::array<int, 3> key{};
            key[axis] = side;
            key[(axis + 1) % 3] = a;
            key[(axis + 2) % 3] = b;
            return vertex(key);
          };
          const int p = corner(i, j), q = corner(i + 1, j), r = corner(i + 1, j + 1), s = corner(i, j + 1);
          if (side == n) {
            faces.push_back({p, q, r});
            faces.push_back({p, r, s});
          } else {
            faces.push_back({p, r, q});
            faces.push_back({p, s, r});
          }
        }
  TriangleMesh mesh;
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    mesh.positions.row(static_cast<Eigen::Index>(v)) = points[v];
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    mesh.triangles.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
  return mesh;
}

}  // namespace batten::fixtures
