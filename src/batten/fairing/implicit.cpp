#include <algorithm>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten::fairing_detail {

std::vector<char> fixed_vertices(const Points& positions, const Triangles& triangles, bool keep_boundary) {
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (!positions.row(v).allFinite())
      throw InvalidInput(concat("vertex ", v, " has a coordinate that is not finite; repair the mesh first"));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (triangles(f, k) < 0 || triangles(f, k) >= positions.rows())
        throw InvalidInput(concat("triangle ", f, " names vertex ", triangles(f, k),
                                  ", but the mesh has the vertices 0 to ", positions.rows() - 1));
  std::vector<char> fixed(static_cast<std::size_t>(positions.rows()), 0);
  const std::vector<int> opposite = opposite_half_edges(triangles);
  if (keep_boundary)
    for (std::size_t h = 0; h < opposite.size(); ++h)
      if (opposite[h] < 0)
        for (int k = 1; k < 3; ++k)
          fixed[triangles(static_cast<Eigen::Index>(h / 3), (static_cast<int>(h % 3) + k) % 3)] = 1;
  return fixed;
}

void solve_with_fixed(SparseCholesky& solver, const SparseMatrix& A, const Eigen::MatrixXd& B,
                      const std::vector<char>& fixed, Points& X, const Progress& progress) {
  const Eigen::Index n = A.rows();
  std::vector<int> index(static_cast<std::size_t>(n), -1);
  int unknowns = 0;
  for (Eigen::Index v = 0; v < n; ++v)
    if (!fixed[v]) index[v] = unknowns++;
  if (unknowns == 0) return;
  if (unknowns == n) {
    solver.factorize(A, progress);
    X = solver.solve(B);
    return;
  }
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(static_cast<std::size_t>(A.nonZeros()));
  Eigen::MatrixXd right(unknowns, 3);
  for (Eigen::Index v = 0; v < n; ++v)
    if (!fixed[v]) right.row(index[v]) = B.row(v);
  for (Eigen::Index column = 0; column < n; ++column)
    for (SparseMatrix::InnerIterator entry(A, column); entry; ++entry) {
      if (fixed[entry.row()]) continue;
      if (fixed[column])
        right.row(index[entry.row()]) -= entry.value() * X.row(column);
      else if (entry.row() >= column)
        triplets.emplace_back(index[entry.row()], index[column], entry.value());
    }
  SparseMatrix reduced(unknowns, unknowns);
  reduced.setFromTriplets(triplets.begin(), triplets.end());
  solver.factorize(reduced, progress);
  const Eigen::MatrixXd solution = solver.solve(right);
  for (Eigen::Index v = 0; v < n; ++v)
    if (!fixed[v]) X.row(v) = solution.row(index[v]);
}

Eigen::VectorXd bounded_mass(const Points& positions, const Triangles& triangles) {
  Eigen::VectorXd mass = lumped_mass(positions, triangles);
  const double mean = mass.size() > 0 ? mass.mean() : 0;
  return mass.cwiseMax(mean > 0 ? 1e-3 * mean : 1.0);
}

SparseMatrix bounded_stiffness(const Points& positions, const Triangles& triangles) {
  return cotangent_stiffness(triangles, edge_lengths(positions, triangles), positions.rows(), {20.0});
}

}  // namespace batten::fairing_detail
