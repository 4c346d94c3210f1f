#include "batten/operators/curvature.hpp"

#include <cmath>

#include <Eigen/Dense>

#include "batten/core/units.hpp"
#include "batten/operators/gradient.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

double corner_angle(const Points& positions, const Triangles& triangles, Eigen::Index f, int k) {
  const Vector3d x = positions.row(triangles(f, k));
  const Vector3d a = positions.row(triangles(f, (k + 1) % 3)).transpose() - x;
  const Vector3d b = positions.row(triangles(f, (k + 2) % 3)).transpose() - x;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::VectorXd angle_deficits(const Points& positions, const Triangles& triangles,
                               const std::vector<char>& on_border) {
  Eigen::VectorXd deficit = Eigen::VectorXd::Zero(positions.rows());
  std::vector<char> used(positions.rows(), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      used[triangles(f, k)] = 1;
      deficit[triangles(f, k)] -= corner_angle(positions, triangles, f, k);
    }
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (used[v]) deficit[v] += on_border[v] ? kPi : 2 * kPi;
  return deficit;
}

}  // namespace

std::vector<char> border_vertices(const Triangles& triangles, Eigen::Index n_vertices) {
  std::vector<char> on_border(n_vertices, 0);
  const std::vector<int> opposite = opposite_half_edges(triangles);
  for (std::size_t h = 0; h < opposite.size(); ++h)
    if (opposite[h] < 0) {
      const auto f = static_cast<Eigen::Index>(h / 3);
      on_border[triangles(f, (h + 1) % 3)] = 1;
      on_border[triangles(f, (h + 2) % 3)] = 1;
    }
  return on_border;
}

Curvatures discrete_curvatures(const Points& positions, const Triangles& triangles) {
  const Eigen::Index n = positions.rows();
  const EdgeLengths lengths = edge_lengths(positions, triangles);
  const SparseMatrix K = cotangent_stiffness(triangles, lengths, n);
  const Eigen::VectorXd mass = lumped_mass(triangles, lengths, n);
  Curvatures result;
  result.on_border = border_vertices(triangles, n);
  result.mean_vector = K * positions;
  result.gaussian = angle_deficits(positions, triangles, result.on_border);
  Points normals = Points::Zero(n, 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                     c = positions.row(triangles(f, 2));
      const Vector3d normal = (b - a).cross(c - a);
      if (normal.norm() > 0)
        normals.row(triangles(f, k)) += corner_angle(positions, triangles, f, k) * normal.normalized();
    }
  result.mean = result.maximal = result.minimal = Eigen::VectorXd::Zero(n);
  for (Eigen::Index v = 0; v < n; ++v) {
    if (mass[v] > 0) {
      result.mean_vector.row(v) /= mass[v];
      result.gaussian[v] /= mass[v];
    }
    // The vector is parallel to the normal up to the error of the discretisation: its length is the better
    // figure, the vertex normal gives only the sign.
    const double along = result.mean_vector.row(v).dot(normals.row(v));
    result.mean[v] = std::copysign(0.5 * result.mean_vector.row(v).norm(), along);
    const double root = std::sqrt(std::max(0.0, result.mean[v] * result.mean[v] - result.gaussian[v]));
    result.maximal[v] = result.mean[v] + root;
    result.minimal[v] = result.mean[v] - root;
  }
  return result;
}

Points curvature_from_divergence(const Points& positions, const Triangles& triangles) {
  const SparseMatrix gradient = vertex_gradient(positions, triangles);
  const SparseMatrix divergence = vertex_divergence(positions, triangles);
  return -(divergence * (gradient * positions));
}

double total_angle_deficit(const Points& positions, const Triangles& triangles) {
  return angle_deficits(positions, triangles, border_vertices(triangles, positions.rows())).sum();
}

Points integrated_curvature_from_normals(const Points& positions, const Points& normals,
                                         const Triangles& triangles) {
  Points sum = Points::Zero(positions.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    Vector3d normal = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) normal += normals.row(triangles(f, k)).transpose();
    const double length = normal.norm();
    if (!(length > 0)) continue;
    normal /= 2 * length;
    for (int k = 0; k < 3; ++k) {
      const Vector3d edge =
          positions.row(triangles(f, (k + 2) % 3)) - positions.row(triangles(f, (k + 1) % 3));
      sum.row(triangles(f, k)) += edge.cross(normal).transpose();
    }
  }
  return sum;
}

}  // namespace batten
