#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/shape.hpp"
#include "batten/mesh/triangle_mesh.hpp"

/// Shapes with known geometry for the tests of meshes, registration and pictures.
namespace batten::fixtures {

/// The triangles of a shape.
inline TriangleMesh as_mesh(const Shape& shape) {
  TriangleMesh mesh;
  mesh.positions = shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
}

/// A grid over (u, v) ∈ [0, 1]² with n × m cells; `closed` glues the two ends of each direction.
inline Shape grid(int n, int m, bool closed_u, bool closed_v,
                  const std::function<Eigen::Vector3d(double, double)>& point) {
  const int nu = closed_u ? n : n + 1, nv = closed_v ? m : m + 1;
  Shape shape;
  shape.positions.resize(nu * nv, 3);
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j)
      shape.positions.row(i * nv + j) = point(i / static_cast<double>(n), j / static_cast<double>(m));
  shape.triangles.resize(2 * n * m, 3);
  int t = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const int a = i * nv + j, b = (i + 1) % nu * nv + j, c = (i + 1) % nu * nv + (j + 1) % nv,
                d = i * nv + (j + 1) % nv;
      shape.triangles.row(t++) << a, b, c;
      shape.triangles.row(t++) << a, c, d;
    }
  return shape;
}

/// Octahedron subdivided to n × n triangles per face, pushed to the sphere of radius r; outward.
inline Shape sphere(int n, double r = 1, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  Shape shape;
  const int per_face = (n + 1) * (n + 2) / 2;
  shape.positions.resize(8 * per_face, 3);
  shape.triangles.resize(8 * n * n, 3);
  int vertex = 0, t = 0;
  for (int face = 0; face < 8; ++face) {
    const double sx = (face & 1) != 0 ? -1 : 1, sy = (face & 2) != 0 ? -1 : 1, sz = (face & 4) != 0 ? -1 : 1;
    const bool flip = sx * sy * sz < 0;
    const int first = vertex;
    const auto index = [&](int i, int j) { return first + i * (2 * n + 3 - i) / 2 + j; };
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n - i; ++j) {
        const Eigen::Vector3d p(sx * i, sy * j, sz * (n - i - j));
        shape.positions.row(vertex++) = centre + r * p.normalized();
      }
    const auto add = [&](int a, int b, int c) {
      if (flip)
        shape.triangles.row(t++) << a, c, b;
      else
        shape.triangles.row(t++) << a, b, c;
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n - i; ++j) {
        add(index(i, j), index(i + 1, j), index(i, j + 1));
        if (i + j + 1 < n) add(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
      }
  }
  return shape;
}

/// A blob without any symmetry, so that a registration has one answer.
inline Shape blob(int n) {
  Shape shape = sphere(n);
  for (Eigen::Index i = 0; i < shape.positions.rows(); ++i) {
    const Eigen::Vector3d p = shape.positions.row(i);
    shape.positions.row(i) *=
        1 + 0.2 * std::sin(2 * p.x() + 1) * std::cos(3 * p.y()) + 0.3 * p.z() * p.x() + 0.15 * p.y();
  }
  return shape;
}

/// A closed space curve of n segments without symmetry.
inline Shape knot(int n) {
  Shape shape;
  shape.positions.resize(n, 3);
  shape.segments.resize(n, 2);
  for (int i = 0; i < n; ++i) {
    const double t = 2 * 3.14159265358979323846 * i / n;
    shape.positions.row(i) << std::cos(t) + 0.3 * std::cos(2 * t + 1), std::sin(t) + 0.1 * std::cos(3 * t),
        0.4 * std::sin(2 * t) + 0.2 * std::cos(t);
    shape.segments.row(i) << i, (i + 1) % n;
  }
  return shape;
}

/// The cube from `low` to low + size with n × n cells a face, two triangles each; closed, outward.
inline TriangleMesh box(int n, const Eigen::Vector3d& low = Eigen::Vector3d::Zero(), double size = 1) {
  const int side = n + 1;
  std::vector<int> number(static_cast<size_t>(side * side * side), -1);
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> faces;
  const auto vertex = [&](const std::array<int, 3>& p) {
    int& index = number[static_cast<size_t>((p[0] * side + p[1]) * side + p[2])];
    if (index < 0) {
      index = static_cast<int>(points.size());
      points.emplace_back(low + size * Eigen::Vector3d(p[0], p[1], p[2]) / n);
    }
    return index;
  };
  for (size_t axis = 0; axis < 3; ++axis)
    for (const int end : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int u, int v) {
            std::array<int, 3> p{};
            p[axis] = end;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            return vertex(p);
          };
          const int a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
          if (end > 0) {
            faces.push_back({a, b, c});
            faces.push_back({a, c, d});
          } else {
            faces.push_back({a, c, b});
            faces.push_back({a, d, c});
          }
        }
  TriangleMesh mesh;
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (size_t v = 0; v < points.size(); ++v) mesh.positions.row(static_cast<Eigen::Index>(v)) = points[v];
  mesh.triangles = Eigen::Map<const Triangles>(faces[0].data(), static_cast<Eigen::Index>(faces.size()), 3);
  return mesh;
}

}  // namespace batten::fixtures
