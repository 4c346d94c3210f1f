#include "batten/simplification/p_laplacian.hpp"

#include <cmath>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

std::optional<std::string> PLaplacianOptions::problem() const {
  if (!(p > 0 && p <= 2)) return concat("p must be above 0 and at most 2, got ", p);
  if (fidelity && !(*fidelity >= 0 && std::isfinite(*fidelity)))
    return concat("fidelity must be at least 0, got ", *fidelity);
  if (!(time_step > 0 && std::isfinite(time_step)))
    return concat("time_step must be above 0, got ", time_step);
  if (steps < 0) return concat("steps must be at least 0, got ", steps);
  if (!(epsilon > 0 && std::isfinite(epsilon))) return concat("epsilon must be above 0, got ", epsilon);
  if (!(sigma > 0 && std::isfinite(sigma))) return concat("sigma must be above 0, got ", sigma);
  return std::nullopt;
}

Points p_laplacian_flow(const Points& positions, const Triangles& triangles, const PLaplacianOptions& options,
                        const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const Eigen::Index n = positions.rows();
  if (triangles.rows() == 0 || options.steps == 0) return positions;

  // The pattern of the mesh: every edge once, i > j, and the diagonal.
  const SparseMatrix pattern = uniform_stiffness(triangles, n);
  struct Edge {
    int i, j;
    double weight;
  };
  std::vector<Edge> edges;
  for (Eigen::Index j = 0; j < n; ++j)
    for (SparseMatrix::InnerIterator it(pattern, j); it; ++it)
      if (it.row() > j && it.value() != 0)
        edges.push_back({static_cast<int>(it.row()), static_cast<int>(j), 1.0});
  double mean_length = 0;
  for (const Edge& e : edges) mean_length += (positions.row(e.i) - positions.row(e.j)).norm();
  mean_length /= static_cast<double>(edges.size());
  if (!(mean_length > 0)) return positions;

  const Curvatures curvatures = discrete_curvatures(positions, triangles);
  Eigen::VectorXd H = curvatures.mean;
  for (Eigen::Index v = 0; v < n; ++v)
    if (curvatures.on_border[v] != 0) H[v] = 0;  // no curvature is known there
  const double largest = H.cwiseAbs().maxCoeff();
  if (largest > 0) H /= largest;
  const double epsilon = options.epsilon;
  for (Edge& e : edges) {
    if (options.weight == FlowWeight::InverseLength)
      e.weight = 1 / (epsilon + (positions.row(e.i) - positions.row(e.j)).norm() / mean_length);
    if (options.weight == FlowWeight::Curvature)
      e.weight = std::exp(-std::pow(H[e.i] - H[e.j], 2) / options.sigma);
  }
  Eigen::VectorXd lambda(n);
  for (Eigen::Index v = 0; v < n; ++v)
    lambda[v] = options.fidelity ? *options.fidelity : std::sqrt(std::abs(H[v]) + epsilon);

  const double dt = options.time_step;
  Points X = positions;
  SparseCholesky solver("p-Laplacian flow");
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::VectorXd gradient2(n), b(n), diagonal(n);
  for (int step = 0; step < options.steps; ++step) {
    const Progress part =
        progress.part("flow", static_cast<double>(step) / options.steps, (step + 1.0) / options.steps);
    part.report("flow", 0);
    // |∇f(X_i)|² over all edges at i and all coordinates (2.91, 2.96), in mean edge lengths.
    gradient2.setZero();
    for (const Edge& e : edges) {
      const double d2 = e.weight * (X.row(e.i) - X.row(e.j)).squaredNorm() / (mean_length * mean_length);
      gradient2[e.i] += d2;
      gradient2[e.j] += d2;
    }
    for (Eigen::Index v = 0; v < n; ++v) b[v] = std::pow(gradient2[v] + epsilon, 0.5 * (options.p - 2));
    diagonal = Eigen::VectorXd::Ones(n) + dt * lambda;
    triplets.clear();
    Eigen::MatrixXd right = X + dt * (lambda.asDiagonal() * positions);
    const auto stays = [&](int v) { return curvatures.on_border[v] != 0; };
    for (const Edge& e : edges) {
      const double g = 0.5 * dt * e.weight * (b[e.i] + b[e.j]);  // dt/2 γ (2.94)
      // Border vertices stay: their columns go to the right-hand side.
      if (!stays(e.i)) diagonal[e.i] += g;
      if (!stays(e.j)) diagonal[e.j] += g;
      if (!stays(e.i) && !stays(e.j)) triplets.emplace_back(e.i, e.j, -g);
      if (stays(e.i) && !stays(e.j)) right.row(e.j) += g * positions.row(e.i);
      if (stays(e.j) && !stays(e.i)) right.row(e.i) += g * positions.row(e.j);
    }
    for (Eigen::Index v = 0; v < n; ++v) {
      if (stays(static_cast<int>(v))) right.row(v) = diagonal[v] * positions.row(v);
      triplets.emplace_back(v, v, diagonal[v]);
    }
    SparseMatrix A(n, n);
    A.setFromTriplets(triplets.begin(), triplets.end());
    solver.factorize(A, part);
    X = solver.solve(right);
  }
  return X;
}

}  // namespace batten
