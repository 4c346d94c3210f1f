#pragma once
#include "mesh/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
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
  const TriangleMesh cube = box(n, {-1, -1, -1}, 2);
  return {cube.positions, cube.triangles};
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
