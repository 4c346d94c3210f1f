#include "batten/fairing/surface_diffusion.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

namespace fairing_detail {

SparseMatrix similar_stiffness(const SparseMatrix& K, const Eigen::MatrixXd& H, double similarity) {
  SparseMatrix weighted = K;  // NOLINT(performance-unnecessary-copy-initialization): iterators write into it
  VectorXd sums = VectorXd::Zero(K.rows());
  for (Eigen::Index column = 0; column < K.cols(); ++column)
    for (SparseMatrix::InnerIterator entry(weighted, column); entry; ++entry)
      if (entry.row() != column) {
        // Negative cotangents would make the similar repel each other.
        const double weight = std::max(0.0, -entry.value()) *
                              std::exp(-(H.row(entry.row()) - H.row(column)).squaredNorm() / similarity);
        entry.valueRef() = -weight;
        sums[column] += weight;
      }
  for (Eigen::Index column = 0; column < K.cols(); ++column)
    for (SparseMatrix::InnerIterator entry(weighted, column); entry; ++entry)
      if (entry.row() == column) entry.valueRef() = sums[column];
  return weighted;
}

}  // namespace fairing_detail

std::optional<std::string> SurfaceDiffusionOptions::problem() const {
  if (!(similarity > 0)) return concat("similarity must be above 0, got ", similarity);
  if (!(fidelity > 0)) return concat("fidelity must be above 0, got ", fidelity);
  if (!(time_step >= 0)) return concat("time_step must be at least 0, got ", time_step);
  if (steps < 0) return concat("steps must be at least 0, got ", steps);
  return std::nullopt;
}

Points surface_diffusion(const Points& positions, const Triangles& triangles,
                         const SurfaceDiffusionOptions& options, SurfaceDiffusionReport* report,
                         const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const std::vector<char> fixed = fairing_detail::fixed_vertices(positions, triangles, options.keep_boundary);
  SurfaceDiffusionReport own;
  SurfaceDiffusionReport& told = report != nullptr ? *report : own;
  told = {};
  if (triangles.rows() == 0) return positions;

  // K with positive weights only, and the sums of the weights D: L = −D⁻¹K has normalised rows.
  const SparseMatrix K = fairing_detail::similar_stiffness(
      fairing_detail::bounded_stiffness(positions, triangles), MatrixXd::Zero(positions.rows(), 1), 1.0);
  VectorXd D = K.diagonal();
  D = D.cwiseMax(1e-6 * std::max(D.mean(), 1e-300));
  const Points LX = -(D.cwiseInverse().asDiagonal() * (K * positions));
  const Points normals = vertex_normals(positions, triangles);
  MatrixXd H = options.scalar ? MatrixXd(LX.cwiseProduct(normals).rowwise().sum()) : MatrixXd(LX);
  const double largest = H.rowwise().norm().maxCoeff();
  double tau = options.time_step;
  if (tau == 0) {
    if (!(largest > 0)) return positions;
    tau = mean_edge_length(positions, triangles) / largest;  // (1.45)
  }
  told.time_step = tau;

  SparseCholesky diffusion("diffusion of curvature");
  for (int step = 0; step < options.steps; ++step) {
    progress.report("fairing", 0.5 * step / options.steps);
    const double scale = H.rowwise().norm().maxCoeff();
    if (!(scale > 0)) break;
    const SparseMatrix Kw =
        options.nonlocal ? fairing_detail::similar_stiffness(K, H / scale, options.similarity) : K;
    diffusion.factorize(tau * Kw + SparseMatrix(D.asDiagonal()));  // (2.29) times D
    H = diffusion.solve(D.asDiagonal() * H);
  }
  progress.report("fairing", 0.5);
  const Points target = options.scalar ? Points(VectorXd(H.col(0)).asDiagonal() * normals) : Points(H);
  const SparseMatrix system =
      SparseMatrix(K * D.cwiseAbs2().cwiseInverse().asDiagonal() * K) +
      SparseMatrix(VectorXd::Constant(positions.rows(), options.fidelity).asDiagonal());
  // Lᵀ H = −K D⁻¹ H
  const MatrixXd right = options.fidelity * positions - K * (D.cwiseInverse().asDiagonal() * target);
  Points X = positions;
  SparseCholesky refit("refit to curvature");
  fairing_detail::solve_with_fixed(refit, system, right, fixed, X, progress);
  told.largest_move = (X - positions).rowwise().norm().maxCoeff();
  return X;
}

}  // namespace batten
