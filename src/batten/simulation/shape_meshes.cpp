#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/simulation/shape_formulas_detail.hpp"
#include "batten/simulation/shape_meshes_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

/// Appends the two triangles of the quadrilateral a b c d, counter-clockwise.
void add_quad(std::vector<Eigen::Vector3i>& triangles, int a, int b, int c, int d) {
  triangles.emplace_back(a, b, c);
  triangles.emplace_back(a, c, d);
}

}  // namespace

TriangleMesh ShapeMeshBuilder::finish(const ImplicitFunction& surface) const {
  TriangleMesh mesh;
  mesh.positions.resize(static_cast<Eigen::Index>(positions.size()), 3);
  mesh.normals.resize(static_cast<Eigen::Index>(positions.size()), 3);
  for (size_t v = 0; v < positions.size(); ++v) {
    Vector3d gradient;
    surface(positions[v], gradient);
    mesh.positions.row(static_cast<Eigen::Index>(v)) = positions[v];
    mesh.normals.row(static_cast<Eigen::Index>(v)) = gradient.normalized();
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (size_t f = 0; f < triangles.size(); ++f)
    mesh.triangles.row(static_cast<Eigen::Index>(f)) = triangles[f];
  return mesh;
}

ShapeMeshBuilder star_mesh(int n, const std::function<Vector3d(const Vector3d&)>& place) {
  ShapeMeshBuilder mesh;
  // Latitude ring k of 0 … 2n has 4 min(k, 2n − k) vertices, one at each pole.
  std::vector<int> first(static_cast<size_t>(2 * n) + 2, 0);
  const auto ring_size = [n](int k) { return k == 0 || k == 2 * n ? 1 : 4 * std::min(k, 2 * n - k); };
  for (int k = 0; k <= 2 * n; ++k) {
    const int size = ring_size(k);
    first[static_cast<size_t>(k) + 1] = first[static_cast<size_t>(k)] + size;
    const int side = std::max(1, size / 4);
    for (int j = 0; j < size; ++j) {
      // A point of the octahedron |x| + |y| + |z| = n, walking round the square of the ring.
      const int quarter = j / side;
      const double along = j % side;
      const double reach = size == 1 ? 0 : side;
      const double x[4] = {reach - along, -along, along - reach, along};
      const double y[4] = {along, reach - along, -along, along - reach};
      const Vector3d p(size == 1 ? 0 : x[quarter], size == 1 ? 0 : y[quarter], n - k);
      mesh.add(place(p.normalized()));
    }
  }
  // Two neighbouring rings are zipped quarter by quarter.
  const auto zip = [&](int inner, int outer, bool up) {  // up: the inner ring is nearer to the north pole
    const int inner_size = ring_size(inner);
    const int outer_size = ring_size(outer);
    const int side = outer_size / 4;
    const auto vertex = [&](int ring, int size, int j) {
      return first[static_cast<size_t>(ring)] + j % size;
    };
    for (int q = 0; q < 4; ++q)
      for (int j = 0; j < side; ++j) {
        const int o0 = vertex(outer, outer_size, q * side + j);
        const int o1 = vertex(outer, outer_size, q * side + j + 1);
        const int i0 = vertex(inner, inner_size, q * (side - 1) + j);
        if (up)
          mesh.triangles.emplace_back(o0, o1, i0);
        else
          mesh.triangles.emplace_back(o0, i0, o1);
        if (j + 1 == side) continue;
        const int i1 = vertex(inner, inner_size, q * (side - 1) + j + 1);
        if (up)
          mesh.triangles.emplace_back(i0, o1, i1);
        else
          mesh.triangles.emplace_back(i0, i1, o1);
      }
  };
  for (int k = 0; k < n; ++k) zip(k, k + 1, true);
  for (int k = 2 * n; k > n; --k) zip(k, k - 1, false);
  return mesh;
}

ShapeMeshBuilder grid_mesh(int nu, int nv, bool wrap_u, bool wrap_v,
                           const std::function<Vector3d(double, double)>& place) {
  ShapeMeshBuilder mesh;
  const int columns = wrap_u ? nu : nu + 1;
  const int rows = wrap_v ? nv : nv + 1;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      mesh.add(place(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
  const auto vertex = [=](int i, int j) { return (j % rows) * columns + i % columns; };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      add_quad(mesh.triangles, vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
  return mesh;
}

ShapeMeshBuilder disc_mesh(int rings, const std::function<Vector3d(double, double)>& place) {
  ShapeMeshBuilder mesh;
  mesh.add(place(0, 0));
  const auto vertex = [](int ring, int j) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + j % (6 * ring);
  };
  for (int ring = 1; ring <= rings; ++ring) {
    const double r = static_cast<double>(ring) / rings;
    for (int j = 0; j < 6 * ring; ++j) {
      const double phi = kPi * j / (3 * ring);
      mesh.add(place(r * std::cos(phi), r * std::sin(phi)));
    }
    for (int sector = 0; sector < 6; ++sector)
      for (int j = 0; j < ring; ++j) {
        const int o0 = vertex(ring, sector * ring + j);
        const int o1 = vertex(ring, sector * ring + j + 1);
        const int i0 = vertex(ring - 1, sector * (ring - 1) + j);
        mesh.triangles.emplace_back(o0, o1, i0);
        if (j + 1 < ring) mesh.triangles.emplace_back(i0, o1, vertex(ring - 1, sector * (ring - 1) + j + 1));
      }
  }
  return mesh;
}

ShapeMeshBuilder build_mesh(AnalyticShape shape, double edge) {
  // Even numbers of cells put vertices on the symmetry planes, so that the box is met exactly.
  const auto cells = [edge](double length) {
    return std::max(8, 4 * static_cast<int>(std::ceil(length / edge / 4)));
  };
  switch (shape) {
    case AnalyticShape::Sphere:
    case AnalyticShape::Sphere6:
      return star_mesh(cells(kPi / 2), [](const Vector3d& d) { return d; });
    case AnalyticShape::Ellipsoid:
      return star_mesh(cells(kPi / 2 * kEllipsoidAxes.maxCoeff()),
                       [](const Vector3d& d) { return Vector3d(d.cwiseProduct(kEllipsoidAxes)); });
    case AnalyticShape::BumpyCube:
      return star_mesh(cells(2.0), on_bumpy_cube);
    case AnalyticShape::Torus:
      return grid_mesh(cells(2 * kPi * (kTorusRadius + kTubeRadius)), cells(2 * kPi * kTubeRadius), true,
                       true, [](double u, double v) {
                         const double phi = 2 * kPi * u;
                         const double rho = kTorusRadius + kTubeRadius * std::cos(2 * kPi * v);
                         return Vector3d(rho * std::cos(phi), rho * std::sin(phi),
                                         kTubeRadius * std::sin(2 * kPi * v));
                       });
    case AnalyticShape::Saddle:
    case AnalyticShape::Waves:
      return grid_mesh(cells(2), cells(2), false, false, [shape](double u, double v) {
        const double x = 2 * u - 1;
        const double y = 2 * v - 1;
        return Vector3d(x, y, height_field(shape)(x, y).z);
      });
    case AnalyticShape::Dish:
      return disc_mesh(cells(1), [](double x, double y) { return Vector3d(x, y, dish_height(x, y).z); });
    case AnalyticShape::Cone:
      return grid_mesh(cells(2 * kPi * cone_radius(kConeBottom)), cells((kConeTop - kConeBottom) * 1.03),
                       true, false, [](double u, double v) {
                         const double phi = 2 * kPi * u;
                         const double z = kConeBottom + v * (kConeTop - kConeBottom);
                         const double r = cone_radius(z);
                         return Vector3d(r * std::cos(phi), r * std::sin(phi), z);
                       });
  }
  throw InvalidInput("unknown shape");
}

}  // namespace batten::detail
