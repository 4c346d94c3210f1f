#include "batten/remeshing/regularization.hpp"

#include <cmath>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/statistics.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Sets every diagonal entry so that its row sums to zero. @pre the diagonal is in the pattern.
void balance_diagonal(SparseMatrix& matrix) {
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) {
    double sum = 0;
    double* diagonal = nullptr;
    for (SparseMatrix::InnerIterator entry(matrix, i); entry; ++entry)
      if (entry.row() == i)
        diagonal = &entry.valueRef();
      else
        sum += entry.value();
    if (diagonal != nullptr) *diagonal = -sum;
  }
}

/// Curvature scaled to maximum 1. The maximum is that of all but a thousandth: one spike of a scan must not
/// flatten the rest.
Eigen::VectorXd scaled_to_one(const Eigen::VectorXd& curvature) {
  if (curvature.size() == 0) return curvature;
  Eigen::VectorXd sorted = curvature.cwiseAbs();
  const auto size = static_cast<std::size_t>(sorted.size());
  const double most = order_statistic({sorted.data(), size}, size - 1 - size / 1000);
  return most > 0 ? Eigen::VectorXd((curvature.cwiseAbs() / most).cwiseMin(1.0)) : curvature;
}

/// A matrix of the pattern of `stiffness` whose column i holds row i of a matrix of weighted means: entry
/// weight(i, j, w_ij) per neighbour, over their sum; −1 on the diagonal. Stored transposed, so that a row is
/// contiguous.
template <typename Weight>
SparseMatrix mean_matrix(const SparseMatrix& stiffness, const Weight& weight) {
  SparseMatrix L = stiffness;  // NOLINT(performance-unnecessary-copy-initialization): iterators write into it
  parallel_for(L.cols(), 2048, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      double sum = 0;
      for (SparseMatrix::InnerIterator entry(L, i); entry; ++entry)
        if (entry.row() != i) sum += entry.valueRef() = weight(i, entry.row(), -entry.value());
      for (SparseMatrix::InnerIterator entry(L, i); entry; ++entry)
        entry.valueRef() = entry.row() == i ? (sum > 0 ? -1.0 : 0.0) : (sum > 0 ? entry.value() / sum : 0.0);
    }
  });
  return L;
}

}  // namespace

SparseMatrix clamped_stiffness(const Triangles& triangles, const EdgeLengths& lengths,
                               Eigen::Index n_vertices) {
  SparseMatrix K = cotangent_stiffness(triangles, lengths, n_vertices);
  for (Eigen::Index i = 0; i < K.cols(); ++i)
    for (SparseMatrix::InnerIterator entry(K, i); entry; ++entry)
      if (entry.row() != i && entry.value() > 0) entry.valueRef() = 0;
  balance_diagonal(K);
  return K;
}

RegularizedAreas regularized_areas(const SparseMatrix& stiffness, const Eigen::VectorXd& areas,
                                   const Eigen::VectorXd& curvature, const Eigen::VectorXd& shares,
                                   double sigma, const Progress& progress) {
  const Eigen::VectorXd H = scaled_to_one(curvature);
  SparseMatrix K = stiffness;
  for (Eigen::Index i = 0; i < K.cols(); ++i)
    for (SparseMatrix::InnerIterator entry(K, i); entry; ++entry) {
      const double difference = H[i] - H[entry.row()];
      entry.valueRef() *= std::exp(-difference * difference / sigma);
    }
  balance_diagonal(K);
  const Eigen::VectorXd density = areas.cwiseQuotient(shares);
  const double speed = (K * density).cwiseAbs().maxCoeff();
  if (!(speed > 0)) return {areas, {0, 0, true}};
  K *= 10 * density.mean() / speed;
  for (Eigen::Index i = 0; i < K.cols(); ++i) K.coeffRef(i, i) += 1;
  // The step is short and the matrix near its diagonal: an incomplete factor would cost more than it saves.
  IterativeOptions options;
  options.tolerance = 1e-4;
  options.preconditioner = Preconditioner::Diagonal;
  RegularizedAreas result{areas, {}};
  Eigen::MatrixXd diffused = density;
  try {
    result.solve = solve_conjugate_gradients(K, density, diffused, "diffusion of areas", options, progress);
  } catch (const SolverFailure&) {
    result.solve.residual = 1;  // nothing of the right-hand side was met
    return result;
  }
  const Eigen::VectorXd wanted = diffused.col(0).cwiseProduct(shares);
  if (wanted.minCoeff() > 0)
    result.areas = wanted * (areas.sum() / wanted.sum());
  else
    result.solve.converged = false;
  return result;
}

SparseMatrix relocation_matrix(const SparseMatrix& stiffness, const Points& positions,
                               const Eigen::VectorXd& areas, const Eigen::VectorXd& wanted,
                               const Eigen::VectorXd& lengths, const Eigen::VectorXd& curvature,
                               const RelocationWeights& weights) {
  const Eigen::VectorXd H = scaled_to_one(curvature);
  const Eigen::Index n = positions.rows();
  // Relative to the wanted area of each vertex, so that fine and coarse parts weigh alike; with even sizes
  // this is the printed form up to the mean area.
  const Eigen::VectorXd surplus = (areas - wanted).cwiseQuotient(wanted);
  const auto relative_length = [&](Eigen::Index i, Eigen::Index j) {
    return (positions.row(i) - positions.row(j)).norm() / (0.5 * (lengths[i] + lengths[j]));
  };
  Eigen::VectorXd mean_length = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    int neighbours = 0;
    for (SparseMatrix::InnerIterator entry(stiffness, i); entry; ++entry)
      if (entry.row() != i) {
        mean_length[i] += relative_length(i, entry.row());
        ++neighbours;
      }
    if (neighbours > 0) mean_length[i] /= neighbours;
  }
  SparseMatrix L = mean_matrix(stiffness, [&](Eigen::Index i, Eigen::Index j, double w) {
    const double f =
        weights.area * (surplus[j] - surplus[i]) + weights.edge * (relative_length(i, j) - mean_length[i]);
    return (weights.cotangent ? w : 1.0) / (1 + std::exp(-f / weights.sigma));
  });
  if (weights.curvature > 0)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double s = H[i] / weights.curvature;
      for (SparseMatrix::InnerIterator entry(L, i); entry; ++entry) entry.valueRef() /= 1 + s * s;
    }
  return L;
}

SparseMatrix laplacian_flow_matrix(const SparseMatrix& stiffness, const Eigen::VectorXd& areas,
                                   const Eigen::VectorXd& shares) {
  return mean_matrix(stiffness, [&](Eigen::Index, Eigen::Index j, double) { return areas[j] / shares[j]; });
}

Points relocated(const SparseMatrix& L, const Points& positions, const Points& normals,
                 const Eigen::VectorXd& lengths, const std::vector<char>& fixed, int steps, double share,
                 double most) {
  Points X = positions, next = positions;
  for (int step = 0; step < steps; ++step) {
    parallel_for(X.rows(), 2048, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) {
        if (fixed[i] != 0) continue;
        Vector3d velocity = Vector3d::Zero();
        for (SparseMatrix::InnerIterator entry(L, i); entry; ++entry)
          velocity += entry.value() * X.row(entry.row()).transpose();
        const Vector3d normal = normals.row(i);
        Vector3d move = share * (velocity - normal.dot(velocity) * normal);
        const double limit = most * lengths[i], length = move.norm();
        if (length > limit) move *= limit / length;
        next.row(i) = X.row(i) + move.transpose();
      }
    });
    X.swap(next);
    for (Eigen::Index i = 0; i < X.rows(); ++i)
      if (fixed[i] != 0) X.row(i) = positions.row(i);
  }
  return X;
}

}  // namespace batten
