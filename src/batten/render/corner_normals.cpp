#include "batten/render/corner_normals.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/core/parallel.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

using Eigen::Vector3d;

Points corner_normals(const TriangleMesh& mesh, double crease_angle) {
  const Eigen::Index m = mesh.n_triangles();
  Points corners(3 * m, 3);
  const Points faces = face_normals(mesh.positions, mesh.triangles);
  std::vector<int> first(static_cast<std::size_t>(mesh.n_vertices()) + 1, 0),
      around(static_cast<std::size_t>(3 * m));
  for (Eigen::Index i = 0; i < 3 * m; ++i) ++first[at(mesh.triangles.data()[i]) + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<int> next(first.begin(), first.end() - 1);
  for (Eigen::Index i = 0; i < 3 * m; ++i)
    around[at(next[at(mesh.triangles.data()[i])]++)] = static_cast<int>(i);
  Eigen::VectorXd angles(3 * m);
  for (Eigen::Index t = 0; t < m; ++t)
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = mesh.positions.row(mesh.triangles(t, k));
      const Vector3d u = mesh.positions.row(mesh.triangles(t, (k + 1) % 3)).transpose() - p,
                     v = mesh.positions.row(mesh.triangles(t, (k + 2) % 3)).transpose() - p;
      angles[3 * t + k] = std::atan2(u.cross(v).norm(), u.dot(v));
    }
  const double crease = std::cos(crease_angle);
  parallel_for(m, 4096, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index t = begin; t < end; ++t)
      for (int k = 0; k < 3; ++k) {
        const int v = mesh.triangles(t, k);
        Vector3d sum = Vector3d::Zero();
        for (int i = first[at(v)]; i < first[at(v) + 1]; ++i) {
          const int other = around[at(i)] / 3;
          if (faces.row(other).dot(faces.row(t)) >= crease)
            sum += angles[around[at(i)]] * faces.row(other).transpose();
        }
        const double length = sum.norm();
        corners.row(3 * t + k) = length > 0 ? Vector3d(sum / length) : Vector3d(faces.row(t));
      }
  });
  return corners;
}

}  // namespace batten
