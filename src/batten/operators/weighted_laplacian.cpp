#include "batten/operators/weighted_laplacian.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// tan(angle/2) at corner k: sin/(1 + cos), bounded where the triangle has no area.
double half_tangent(const Points& positions, const Triangles& triangles, Eigen::Index f, int k) {
  const Vector3d x = positions.row(triangles(f, k));
  const Vector3d a = positions.row(triangles(f, (k + 1) % 3)).transpose() - x;
  const Vector3d b = positions.row(triangles(f, (k + 2) % 3)).transpose() - x;
  constexpr double kMost = 1e3;  // an angle of 179.9°
  const double sine = a.cross(b).norm(), below = a.norm() * b.norm() + a.dot(b);
  return sine < kMost * below ? sine / below : (sine > 0 ? kMost : 0.0);
}

/// Off-diagonal entries of S, both directions of every edge.
SparseMatrix edge_matrix(const Points& positions, const Triangles& triangles, bool mean_value) {
  const std::vector<int> opposite = opposite_half_edges(triangles);
  const EdgeLengths lengths = edge_lengths(positions, triangles);
  const double shortest = 1e-12 * (lengths.size() > 0 ? lengths.maxCoeff() : 0);  // no division by zero
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(6 * static_cast<std::size_t>(triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      const double length = std::max(lengths(f, k), shortest);
      if (!(length > 0)) continue;
      if (mean_value) {  // each triangle brings its own angle
        triplets.emplace_back(triangles(f, a), triangles(f, b),
                              half_tangent(positions, triangles, f, a) / length);
        triplets.emplace_back(triangles(f, b), triangles(f, a),
                              half_tangent(positions, triangles, f, b) / length);
      } else {  // an inner edge is seen from both of its triangles
        const double weight = (opposite[static_cast<std::size_t>(3 * f + k)] < 0 ? 1.0 : 0.5) / length;
        triplets.emplace_back(triangles(f, a), triangles(f, b), weight);
        triplets.emplace_back(triangles(f, b), triangles(f, a), weight);
      }
    }
  SparseMatrix S(positions.rows(), positions.rows());
  S.setFromTriplets(triplets.begin(), triplets.end());
  return S;
}

/// Puts minus the sum of each row on its diagonal.
SparseMatrix with_zero_row_sums(const SparseMatrix& S) {
  const VectorXd sums = S * VectorXd::Ones(S.cols());
  return S - SparseMatrix(sums.asDiagonal());
}

/// diag(1/d) S, rows with d = 0 zero.
SparseMatrix divided_rows(const SparseMatrix& S, const VectorXd& d) {
  VectorXd inverse(d.size());
  for (Eigen::Index v = 0; v < d.size(); ++v) inverse[v] = d[v] > 0 ? 1 / d[v] : 0;
  return inverse.asDiagonal() * S;
}

}  // namespace

SparseMatrix weighted_laplacian(const Points& positions, const Triangles& triangles,
                                LaplacianWeights weights) {
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (triangles(f, k) < 0 || triangles(f, k) >= positions.rows())
        throw InvalidInput(concat("triangle ", f, " names vertex ", triangles(f, k),
                                  ", but the mesh has the vertices 0 to ", positions.rows() - 1));
  switch (weights) {
    case LaplacianWeights::Cotangent:
      // K holds half the sum of the two cotangents, negative.
      return divided_rows(-cotangent_stiffness(positions, triangles), lumped_mass(positions, triangles));
    case LaplacianWeights::Umbrella: {
      const SparseMatrix K = uniform_stiffness(triangles, positions.rows());
      return divided_rows(-K, K.diagonal());
    }
    case LaplacianWeights::ScaledUmbrella: {
      SparseMatrix S = edge_matrix(positions, triangles, false);
      VectorXd lengths = VectorXd::Zero(positions.rows());
      for (Eigen::Index column = 0; column < S.outerSize(); ++column)
        for (SparseMatrix::InnerIterator entry(S, column); entry; ++entry)
          lengths[entry.row()] += 1 / entry.value();
      return divided_rows(with_zero_row_sums(S), 0.5 * lengths);
    }
    case LaplacianWeights::MeanValue: {
      const SparseMatrix S = edge_matrix(positions, triangles, true);
      return divided_rows(with_zero_row_sums(S), S * VectorXd::Ones(S.cols()));
    }
  }
  return {};
}

SparseMatrix laplacian_power(const SparseMatrix& L, int power) {
  if (L.rows() != L.cols())
    throw InvalidInput(concat("a power needs a square matrix, got ", L.rows(), " × ", L.cols()));
  if (power < 0) throw InvalidInput(concat("the power must be at least 0, got ", power));
  SparseMatrix result(L.rows(), L.cols());
  result.setIdentity();
  for (int k = 0; k < power; ++k) result = SparseMatrix(L * result);
  return result;
}

}  // namespace batten
