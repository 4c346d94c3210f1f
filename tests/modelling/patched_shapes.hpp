#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten::test {

/// A mesh with a number of its patch per triangle.
struct PatchedMesh {
  TriangleMesh mesh;
  std::vector<int> patches;
};

/// Puts patches together: vertices at the same place (to 1e-9) are one.
class PatchedMeshBuilder {
 public:
  void triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int patch) {
    const std::array<int, 3> t{vertex(a), vertex(b), vertex(c)};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;  // at poles
    triangles_.push_back(t);
    patches_.push_back(patch);
  }
  /// A grid of n × m cells over [u0, u1] × [v0, v1], outside to the left of u × v.
  void grid(const std::function<Eigen::Vector3d(double, double)>& at, std::array<double, 4> range, int n,
            int m, int patch) {
    const auto point = [&](int i, int j) {
      return at(range[0] + (range[1] - range[0]) * i / n, range[2] + (range[3] - range[2]) * j / m);
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < m; ++j) {
        triangle(point(i, j), point(i + 1, j), point(i + 1, j + 1), patch);
        triangle(point(i, j), point(i + 1, j + 1), point(i, j + 1), patch);
      }
  }
  PatchedMesh build() const {
    PatchedMesh result;
    result.patches = patches_;
    result.mesh.positions.resize(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      result.mesh.positions.row(static_cast<Eigen::Index>(v)) = points_[v].transpose();
    result.mesh.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      for (int k = 0; k < 3; ++k)
        result.mesh.triangles(static_cast<Eigen::Index>(f), k) = triangles_[f][static_cast<std::size_t>(k)];
    return result;
  }

 private:
  int vertex(const Eigen::Vector3d& p) {
    std::array<long, 3> key{};
    for (int k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = std::lround(p[k] * 1e9);
    const auto [found, is_new] = number_.try_emplace(key, static_cast<int>(points_.size()));
    if (is_new) points_.push_back(p);
    return found->second;
  }
  std::map<std::array<long, 3>, int> number_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<int> patches_;
};

/// The unit sphere in octants: patches of three sides, meeting in six nodes.
inline PatchedMesh octant_sphere(int n = 24) {
  PatchedMeshBuilder builder;
  for (int octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3d a((octant & 1) ? -1 : 1, 0, 0), b(0, (octant & 2) ? -1 : 1, 0),
        c(0, 0, (octant & 4) ? -1 : 1);
    const bool flipped = a.dot(b.cross(c)) < 0;
    const auto point = [&](int i, int j) {
      return Eigen::Vector3d((i * a + j * b + (n - i - j) * c).normalized());
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const auto add = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
          flipped ? builder.triangle(p, r, q, octant) : builder.triangle(p, q, r, octant);
        };
        add(point(i, j), point(i + 1, j), point(i, j + 1));
        if (i + j + 2 <= n) add(point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
      }
  }
  return builder.build();
}

/// The unit sphere in two halves: outlines without a corner.
inline PatchedMesh half_spheres() {
  PatchedMesh sphere = octant_sphere();
  for (int& patch : sphere.patches) patch = patch < 4 ? 0 : 1;
  return sphere;
}

/// A torus of radii 1 and `tube`, in nu × nv patches of four sides.
inline PatchedMesh torus_of_patches(double tube, int nu, int nv, int cells = 20) {
  PatchedMeshBuilder builder;
  const auto at = [&](double u, double v) {
    return Eigen::Vector3d((1 + tube * std::cos(v)) * std::cos(u), (1 + tube * std::cos(v)) * std::sin(u),
                           tube * std::sin(v));
  };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j)
      builder.grid(at, {2 * kPi * i / nu, 2 * kPi * (i + 1) / nu, 2 * kPi * j / nv, 2 * kPi * (j + 1) / nv},
                   cells, cells, i * nv + j);
  return builder.build();
}

/// A cylinder of radius 1 from z = 0 to `height`: bottom, top, and a side with two outlines. Rims are sharp.
inline PatchedMesh cylinder_of_patches(double height) {
  PatchedMeshBuilder builder;
  constexpr int kAround = 64, kAcross = 12;
  const auto side = [&](double u, double v) { return Eigen::Vector3d(std::cos(u), std::sin(u), v); };
  builder.grid(side, {0, 2 * kPi, 0, height}, kAround, kAcross, 0);
  const auto disc = [&](double z) {
    return [z](double u, double r) { return Eigen::Vector3d(r * std::cos(u), r * std::sin(u), z); };
  };
  builder.grid(disc(0), {0, 2 * kPi, 0, 1}, kAround, kAcross, 1);
  builder.grid(disc(height), {0, 2 * kPi, 1, 0}, kAround, kAcross, 2);
  return builder.build();
}

/// The cube [0, 1]³ with a patch for every face.
inline PatchedMesh cube_of_patches(int cells = 8) {
  PatchedMeshBuilder builder;
  for (int axis = 0; axis < 3; ++axis)
    for (int far = 0; far < 2; ++far) {
      const auto at = [&](double u, double v) {
        Eigen::Vector3d p;
        p[axis] = far;
        p[(axis + 1) % 3] = far ? u : v;
        p[(axis + 2) % 3] = far ? v : u;
        return p;
      };
      builder.grid(at, {0, 1, 0, 1}, cells, cells, 2 * axis + far);
    }
  return builder.build();
}

}  // namespace batten::test
