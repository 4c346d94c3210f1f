#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include <Eigen/Geometry>

#include "batten/core/arrays.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"

/// Closed shapes and measures for the tests of fairing.
namespace batten::fixtures {

struct Mesh {
  Points positions;
  Triangles triangles;
};

/// The cube [−1, 1]³ with n × n cells per face, closed, outward.
inline Mesh cube(int n) {
  std::map<std::array<int, 3>, int> numbers;
  std::vector<std::array<int, 3>> corners;
  std::vector<std::array<int, 3>> faces;
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [it, is_new] = numbers.emplace(p, static_cast<int>(corners.size()));
    if (is_new) corners.push_back(p);
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> p{};
            p[axis] = side * n;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            return vertex(p);
          };
          const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
          if (side == 1) {
            faces.push_back({a, b, c});
            faces.push_back({a, c, d});
          } else {
            faces.push_back({a, c, b});
            faces.push_back({a, d, c});
          }
        }
  Mesh mesh;
  mesh.positions.resize(static_cast<Eigen::Index>(corners.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t v = 0; v < corners.size(); ++v)
    for (int k = 0; k < 3; ++k) mesh.positions(static_cast<Eigen::Index>(v), k) = 2.0 * corners[v][k] / n - 1;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) mesh.triangles(static_cast<Eigen::Index>(f), k) = faces[f][k];
  return mesh;
}

/// The cube pushed out to a sphere of radius r, its cells spread evenly.
inline Mesh closed_sphere(int n, double r = 1) {
  Mesh mesh = cube(n);
  for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
    for (int k = 0; k < 3; ++k) mesh.positions(v, k) = std::tan(mesh.positions(v, k) * kPi / 4);
    mesh.positions.row(v) *= r / mesh.positions.row(v).norm();
  }
  return mesh;
}

/// A square sheet [0, a] × [0, b] of n × m cells in the plane z = 0.
inline Mesh sheet(int n, int m, double a, double b) {
  Mesh mesh;
  mesh.positions.resize((n + 1) * (m + 1), 3);
  mesh.triangles.resize(2 * n * m, 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= m; ++j) mesh.positions.row(i * (m + 1) + j) << a * i / n, b * j / m, 0;
  int t = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const int p = i * (m + 1) + j, q = p + m + 1;
      mesh.triangles.row(t++) << p, q, q + 1;
      mesh.triangles.row(t++) << p, q + 1, p + 1;
    }
  return mesh;
}

/// Mean angle between the normals of the triangles of two meshes of one connectivity, in degrees.
inline double normal_error_deg(const Points& a, const Points& b, const Triangles& triangles) {
  return degrees(mean_normal_angle(a, b, triangles));
}

}  // namespace batten::fixtures
