#include "batten/operators/shape_operator.hpp"

#include <cmath>

#include <Eigen/Dense>

namespace batten {

FaceCurvatures face_curvatures(const Points& positions, const Triangles& triangles,
                               const Points& vertex_normals) {
  const Eigen::Index m = triangles.rows();
  FaceCurvatures curvatures;
  curvatures.first = curvatures.second = Eigen::VectorXd::Zero(m);
  curvatures.first_direction = curvatures.second_direction = Points::Zero(m, 3);
  for (Eigen::Index f = 0; f < m; ++f) {
    const Eigen::Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                          c = positions.row(triangles(f, 2));
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (!(normal.norm() > 0)) continue;
    const Eigen::Vector3d u = (b - a).normalized(), v = normal.normalized().cross(u);
    // Unknowns (S_uu, S_uv, S_vv); two rows per side.
    Eigen::Matrix<double, 6, 3> rows;
    Eigen::Matrix<double, 6, 1> right;
    for (int k = 0; k < 3; ++k) {
      const int i = triangles(f, k), j = triangles(f, (k + 1) % 3);
      const Eigen::Vector3d side = positions.row(j) - positions.row(i);
      const Eigen::Vector3d turn = vertex_normals.row(j) - vertex_normals.row(i);
      const double x = side.dot(u), y = side.dot(v);
      rows.row(2 * k) << x, y, 0;
      rows.row(2 * k + 1) << 0, x, y;
      right[2 * k] = turn.dot(u);
      right[2 * k + 1] = turn.dot(v);
    }
    const Eigen::Vector3d s = (rows.transpose() * rows).ldlt().solve(rows.transpose() * right);
    if (!s.allFinite()) continue;
    const double mean = (s[0] + s[2]) / 2, half = (s[0] - s[2]) / 2, root = std::hypot(half, s[1]);
    const double angle = 0.5 * std::atan2(s[1], half);  // of the direction of mean + root
    double first = mean + root, second = mean - root;
    Eigen::Vector3d along = std::cos(angle) * u + std::sin(angle) * v,
                    across = -std::sin(angle) * u + std::cos(angle) * v;
    if (std::abs(second) > std::abs(first)) {
      std::swap(first, second);
      std::swap(along, across);
    }
    curvatures.first[f] = first;
    curvatures.second[f] = second;
    curvatures.first_direction.row(f) = along;
    curvatures.second_direction.row(f) = across;
  }
  return curvatures;
}

}  // namespace batten
