#include "batten/operators/gradient.hpp"

#include <vector>

#include <Eigen/Dense>

namespace batten {

namespace {

using Eigen::Vector3d;

/// Unnormalised normal of a triangle: twice its area long.
Vector3d area_normal(const Points& positions, const Triangles& triangles, Eigen::Index f) {
  const Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                 c = positions.row(triangles(f, 2));
  return (b - a).cross(c - a);
}

/// ∇ of the hat function of corner k: N × (edge opposite k) / (2 area).
Vector3d hat_gradient(const Points& positions, const Triangles& triangles, Eigen::Index f, int k) {
  const Vector3d normal = area_normal(positions, triangles, f);
  const Vector3d edge = positions.row(triangles(f, (k + 2) % 3)) - positions.row(triangles(f, (k + 1) % 3));
  const double squared = normal.squaredNorm();
  return squared > 0 ? Vector3d(normal.cross(edge) / squared) : Vector3d::Zero();
}

using Triplets = std::vector<Eigen::Triplet<double>>;

SparseMatrix assembled(Eigen::Index rows, Eigen::Index columns, const Triplets& triplets) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

}  // namespace

SparseMatrix face_gradient(const Points& positions, const Triangles& triangles) {
  Triplets triplets;
  triplets.reserve(static_cast<std::size_t>(9 * triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vector3d gradient = hat_gradient(positions, triangles, f, k);
      for (int i = 0; i < 3; ++i) triplets.emplace_back(3 * f + i, triangles(f, k), gradient[i]);
    }
  return assembled(3 * triangles.rows(), positions.rows(), triplets);
}

SparseMatrix face_divergence(const Points& positions, const Triangles& triangles) {
  Triplets triplets;
  triplets.reserve(static_cast<std::size_t>(9 * triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const double area = 0.5 * area_normal(positions, triangles, f).norm();
    for (int k = 0; k < 3; ++k) {
      const Vector3d gradient = hat_gradient(positions, triangles, f, k);
      for (int i = 0; i < 3; ++i) triplets.emplace_back(triangles(f, k), 3 * f + i, -area * gradient[i]);
    }
  }
  return assembled(positions.rows(), 3 * triangles.rows(), triplets);
}

SparseMatrix vertex_gradient(const Points& positions, const Triangles& triangles) {
  Eigen::VectorXd around = Eigen::VectorXd::Zero(positions.rows());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) around[triangles(f, k)] += area_normal(positions, triangles, f).norm();
  Triplets triplets;
  triplets.reserve(static_cast<std::size_t>(27 * triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const double area = area_normal(positions, triangles, f).norm();
    for (int k = 0; k < 3; ++k) {
      const Vector3d gradient = hat_gradient(positions, triangles, f, k);
      for (int corner = 0; corner < 3; ++corner) {
        const int v = triangles(f, corner);
        for (int i = 0; i < 3; ++i)
          if (around[v] > 0)
            triplets.emplace_back(3 * v + i, triangles(f, k), gradient[i] * area / around[v]);
      }
    }
  }
  return assembled(3 * positions.rows(), positions.rows(), triplets);
}

SparseMatrix vertex_divergence(const Points& positions, const Triangles& triangles) {
  // ∇f at v is Σ_u w_vu f_u and div V at v is Σ_u w_vu · V_u with the same vectors w (1.9, 1.12).
  const SparseMatrix gradient = vertex_gradient(positions, triangles);
  Triplets triplets;
  triplets.reserve(static_cast<std::size_t>(gradient.nonZeros()));
  for (Eigen::Index column = 0; column < gradient.outerSize(); ++column)
    for (SparseMatrix::InnerIterator entry(gradient, column); entry; ++entry)
      triplets.emplace_back(entry.row() / 3, 3 * column + entry.row() % 3, entry.value());
  return assembled(positions.rows(), 3 * positions.rows(), triplets);
}

}  // namespace batten
