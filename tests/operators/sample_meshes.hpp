#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include <Eigen/Dense>

#include "batten/core/random.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten::samples {

/// A grid of nu × nv vertices over (u, v), each cell cut in two, mapped to space; periodic where closed.
inline TriangleMesh mapped_grid(int nu, int nv, bool closed_u, bool closed_v,
                                const std::function<Eigen::Vector3d(double, double)>& map,
                                double jitter = 0) {
  TriangleMesh mesh;
  mesh.positions.resize(nu * nv, 3);
  Random random(11);
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const bool inner_u = closed_u || (i > 0 && i + 1 < nu), inner_v = closed_v || (j > 0 && j + 1 < nv);
      const double du = inner_u ? jitter * random.uniform(-0.5, 0.5) : 0;
      const double dv = inner_v ? jitter * random.uniform(-0.5, 0.5) : 0;
      mesh.positions.row(i * nv + j) =
          map((i + du) / (closed_u ? nu : nu - 1), (j + dv) / (closed_v ? nv : nv - 1));
    }
  std::vector<std::array<int, 3>> list;
  for (int i = 0; i < (closed_u ? nu : nu - 1); ++i)
    for (int j = 0; j < (closed_v ? nv : nv - 1); ++j) {
      const int a = i * nv + j, b = ((i + 1) % nu) * nv + j, c = ((i + 1) % nu) * nv + (j + 1) % nv,
                d = i * nv + (j + 1) % nv;
      list.push_back({a, b, c});
      list.push_back({a, c, d});
    }
  mesh.triangles.resize(static_cast<Eigen::Index>(list.size()), 3);
  for (std::size_t f = 0; f < list.size(); ++f)
    mesh.triangles.row(static_cast<Eigen::Index>(f)) << list[f][0], list[f][1], list[f][2];
  return mesh;
}

inline TriangleMesh square(int n, double jitter = 0) {
  return mapped_grid(
      n, n, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); }, jitter);
}

inline TriangleMesh torus(int n, double R = 2, double r = 0.7) {
  return mapped_grid(2 * n, n, true, true, [=](double u, double v) {
    const double a = 2 * 3.14159265358979323846 * u, b = 2 * 3.14159265358979323846 * v;
    return Eigen::Vector3d((R + r * std::cos(b)) * std::cos(a), (R + r * std::cos(b)) * std::sin(a),
                           r * std::sin(b));
  });
}

/// An octahedron of radius R subdivided n-fold onto the sphere, 4 n² + 2 vertices.
inline TriangleMesh octasphere(int n, double R) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> index;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> list;
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
    const auto vertex = [&](int i, int j) {
      const std::array<int, 3> key = {sx * i, sy * j, sz * (n - i - j)};
      const auto [place, is_new] = index.emplace(key, static_cast<int>(points.size()));
      if (is_new) points.push_back(R * Eigen::Vector3d(key[0], key[1], key[2]).normalized());
      return place->second;
    };
    const auto add = [&](int a, int b, int c) {
      if (sx * sy * sz > 0)
        list.push_back({a, b, c});
      else
        list.push_back({a, c, b});
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add(vertex(i + 1, j), vertex(i, j + 1), vertex(i, j));
        if (i + j + 2 <= n) add(vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
      }
  }
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    mesh.positions.row(static_cast<Eigen::Index>(i)) = points[i];
  mesh.triangles.resize(static_cast<Eigen::Index>(list.size()), 3);
  for (std::size_t f = 0; f < list.size(); ++f)
    mesh.triangles.row(static_cast<Eigen::Index>(f)) << list[f][0], list[f][1], list[f][2];
  return mesh;
}

}  // namespace batten::samples
