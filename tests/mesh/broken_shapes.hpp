#pragma once
#include "mesh/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "batten/core/index.hpp"
#include "batten/mesh/triangle_mesh.hpp"

/// Sound shapes and what people's programs make of them.
namespace batten::fixtures {

/// Both, without a vertex in common.
inline TriangleMesh beside(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh;
  mesh.positions.resize(a.n_vertices() + b.n_vertices(), 3);
  mesh.positions << a.positions, b.positions;
  mesh.triangles.resize(a.n_triangles() + b.n_triangles(), 3);
  mesh.triangles << a.triangles, b.triangles.array() + static_cast<int>(a.n_vertices());
  return mesh;
}

/// Vertices at one place (to 1e-9) made one.
inline TriangleMesh glued(const TriangleMesh& given) {
  TriangleMesh mesh;
  std::vector<int> number;
  std::vector<Eigen::RowVector3d> points;
  for (Eigen::Index v = 0; v < given.n_vertices(); ++v) {
    const Eigen::RowVector3d p = given.positions.row(v);
    const auto place =
        std::find_if(points.begin(), points.end(), [&](const auto& q) { return (p - q).norm() < 1e-9; });
    number.push_back(static_cast<int>(place - points.begin()));
    if (place == points.end()) points.push_back(p);
  }
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (size_t v = 0; v < points.size(); ++v) mesh.positions.row(static_cast<Eigen::Index>(v)) = points[v];
  mesh.triangles = given.triangles.unaryExpr([&](int v) { return number[at(v)]; });
  return mesh;
}

/// Every triangle with vertices of its own, each moved by up to `jitter` along every axis.
inline TriangleMesh soup_of(const TriangleMesh& given, double jitter = 0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  TriangleMesh mesh;
  mesh.positions.resize(3 * given.n_triangles(), 3);
  mesh.triangles.resize(given.n_triangles(), 3);
  for (Eigen::Index f = 0; f < given.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k) {
      mesh.triangles(f, k) = static_cast<int>(3 * f + k);
      mesh.positions.row(3 * f + k) = given.positions.row(given.triangles(f, k));
      if (jitter > 0)
        mesh.positions.row(3 * f + k) += Eigen::RowVector3d(move(random), move(random), move(random));
    }
  return mesh;
}

/// Each triangle turned over or not, by chance.
inline TriangleMesh turned_at_random(TriangleMesh mesh, unsigned seed = 1) {
  std::mt19937 random(seed);
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    if ((random() & 1U) != 0) std::swap(mesh.triangles(f, 1), mesh.triangles(f, 2));
  return mesh;
}

inline TriangleMesh with_triangles(TriangleMesh mesh, const std::vector<std::array<int, 3>>& more) {
  const Eigen::Index n = mesh.n_triangles();
  mesh.triangles.conservativeResize(n + static_cast<Eigen::Index>(more.size()), 3);
  for (size_t k = 0; k < more.size(); ++k)
    mesh.triangles.row(n + static_cast<Eigen::Index>(k)) << more[k][0], more[k][1], more[k][2];
  return mesh;
}

/// A band of n cells around a circle with `half_turns` twists; one-sided where they are odd.
inline TriangleMesh band(int n, int half_turns) {
  TriangleMesh mesh;
  mesh.positions.resize(2 * n, 3);
  mesh.triangles.resize(2 * n, 3);
  for (int i = 0; i < n; ++i) {
    const double angle = 6.283185307179586 * i / n, twist = half_turns * angle / 2;
    for (int k = 0; k < 2; ++k) {
      const double s = k == 0 ? -0.3 : 0.3, r = 1 + s * std::cos(twist);
      mesh.positions.row(2 * i + k) << r * std::cos(angle), r * std::sin(angle), s * std::sin(twist);
    }
    const bool flips = i == n - 1 && half_turns % 2 != 0;
    const int a = 2 * i, b = a + 1, next = 2 * ((i + 1) % n), c = next + (flips ? 1 : 0),
              d = next + (flips ? 0 : 1);
    mesh.triangles.row(2 * i) << a, c, d;
    mesh.triangles.row(2 * i + 1) << a, d, b;
  }
  return mesh;
}

}  // namespace batten::fixtures
