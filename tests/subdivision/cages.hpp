#pragma once
#include <cmath>
#include <functional>
#include <initializer_list>
#include <vector>

#include "batten/core/units.hpp"
#include "batten/mesh/control_cage.hpp"

// Cages that the tests of the room share.
namespace batten::cages {

inline void add_face(PolygonMesh& mesh, std::initializer_list<int> corners) {
  mesh.corners.insert(mesh.corners.end(), corners);
  mesh.offsets.push_back(static_cast<int>(mesh.corners.size()));
}

/// [−1, 1]³. Vertices 0–3 below and 4–7 above, both counter-clockwise seen from above; face 1 is the top.
inline ControlCage cube() {
  ControlCage cage;
  cage.mesh.positions.resize(8, 3);
  cage.mesh.positions << -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
  add_face(cage.mesh, {3, 2, 1, 0});
  add_face(cage.mesh, {4, 5, 6, 7});
  add_face(cage.mesh, {0, 1, 5, 4});
  add_face(cage.mesh, {1, 2, 6, 5});
  add_face(cage.mesh, {2, 3, 7, 6});
  add_face(cage.mesh, {3, 0, 4, 7});
  return cage;
}

/// The cube of H fig. 7.6: sharp are the four edges of the top and two uprights.
inline ControlCage cube_with_sharp_edges() {
  ControlCage cage = cube();
  for (const auto& [a, b] :
       std::initializer_list<std::pair<int, int>>{{4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}})
    cage.sharp_edges.push_back({a, b, kInfinitelySharp});
  return cage;
}

/// nx × ny vertices (vertex j nx + i) at surface(i, j).
inline ControlCage grid(int nx, int ny, const std::function<Eigen::RowVector3d(int, int)>& surface) {
  ControlCage cage;
  cage.mesh.positions.resize(nx * ny, 3);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) cage.mesh.positions.row(j * nx + i) = surface(i, j);
  for (int j = 0; j + 1 < ny; ++j)
    for (int i = 0; i + 1 < nx; ++i)
      add_face(cage.mesh, {j * nx + i, j * nx + i + 1, (j + 1) * nx + i + 1, (j + 1) * nx + i});
  return cage;
}

/// A torus of radii 2 and 0.7, n × m quads.
inline ControlCage torus(int n, int m) {
  ControlCage cage;
  cage.mesh.positions.resize(n * m, 3);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const double u = 2 * kPi * i / n, v = 2 * kPi * j / m, r = 2 + 0.7 * std::cos(v);
      cage.mesh.positions.row(j * n + i) << r * std::cos(u), r * std::sin(u), 0.7 * std::sin(v);
    }
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i)
      add_face(cage.mesh,
               {j * n + i, j * n + (i + 1) % n, (j + 1) % m * n + (i + 1) % n, (j + 1) % m * n + i});
  return cage;
}

/// n sectors of rings × rings quads around vertex 0, of valence n, at surface(x, y) over the plane.
inline ControlCage star(int n, int rings, const std::function<Eigen::RowVector3d(double, double)>& surface) {
  ControlCage cage;
  const int per_sector = rings * (rings + 1);
  // Sector s: i = 1 … rings along its spoke, j = 0 … rings towards the next one.
  const auto index = [&](int s, int i, int j) {
    if (i == 0 && j == 0) return 0;
    if (i == 0) return 1 + (s + 1) % n * per_sector + (j - 1) * (rings + 1);
    return 1 + s % n * per_sector + (i - 1) * (rings + 1) + j;
  };
  cage.mesh.positions.resize(1 + n * per_sector, 3);
  cage.mesh.positions.row(0) = surface(0, 0);
  for (int s = 0; s < n; ++s)
    for (int i = 1; i <= rings; ++i)
      for (int j = 0; j <= rings; ++j) {
        const double a = 2 * kPi * s / n, b = 2 * kPi * (s + 1) / n;
        cage.mesh.positions.row(index(s, i, j)) =
            surface(i * std::cos(a) + j * std::cos(b), i * std::sin(a) + j * std::sin(b));
      }
  for (int s = 0; s < n; ++s)
    for (int i = 0; i < rings; ++i)
      for (int j = 0; j < rings; ++j)
        add_face(cage.mesh, {index(s, i, j), index(s, i + 1, j), index(s, i + 1, j + 1), index(s, i, j + 1)});
  return cage;
}

/// A regular tetrahedron, four triangles.
inline ControlCage tetrahedron() {
  ControlCage cage;
  cage.mesh.positions.resize(4, 3);
  cage.mesh.positions << 1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1;
  add_face(cage.mesh, {0, 2, 1});
  add_face(cage.mesh, {0, 1, 3});
  add_face(cage.mesh, {0, 3, 2});
  add_face(cage.mesh, {1, 2, 3});
  return cage;
}

/// A prism over a regular n-gon: two n-gons and n quads; vertices of valence 3.
inline ControlCage prism(int n) {
  ControlCage cage;
  cage.mesh.positions.resize(2 * n, 3);
  for (int k = 0; k < n; ++k) {
    const double a = 2 * kPi * k / n;
    cage.mesh.positions.row(k) << std::cos(a), std::sin(a), -0.5;
    cage.mesh.positions.row(n + k) << std::cos(a), std::sin(a), 0.5;
  }
  for (int k = n; k-- > 0;) cage.mesh.corners.push_back(k);
  cage.mesh.offsets.push_back(n);
  for (int k = 0; k < n; ++k) cage.mesh.corners.push_back(n + k);
  cage.mesh.offsets.push_back(2 * n);
  for (int k = 0; k < n; ++k) add_face(cage.mesh, {k, (k + 1) % n, n + (k + 1) % n, n + k});
  return cage;
}

}  // namespace batten::cages
