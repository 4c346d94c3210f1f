#pragma once
#include <cstdint>
#include <vector>

#include "batten/core/random.hpp"
#include "batten/linalg/iterative.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

// Systems that the tests of solvers share.
namespace batten::fixtures {

/// Four entries in every row at most, one of them larger than the others are likely to be.
inline SparseMatrix random_sparse(int rows, int columns, std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < rows; ++i) {
    entries.emplace_back(i, i % columns, 4.0);
    for (int k = 0; k < 3; ++k) entries.emplace_back(i, random.below(columns), random.normal());
  }
  SparseMatrix A(rows, columns);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// Far below what the tests ask of solutions.
inline const IterativeOptions kTight{.tolerance = 1e-11, .max_iterations = 2000};

/// The five-point Laplacian of an n × n grid plus `shift` on the diagonal: positive definite for shift ≥ 0.
inline SparseMatrix grid_laplacian(int n, double shift) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int k = i * n + j;
      entries.emplace_back(k, k, 4 + shift);
      if (i + 1 < n) entries.emplace_back(k, k + n, -1), entries.emplace_back(k + n, k, -1);
      if (j + 1 < n) entries.emplace_back(k, k + 1, -1), entries.emplace_back(k + 1, k, -1);
    }
  }
  SparseMatrix A(n * n, n * n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// Every backend that there is, and the one that is chosen by size.
inline std::vector<CholeskyBackend> backends() {
  std::vector<CholeskyBackend> list{CholeskyBackend::Auto, CholeskyBackend::Eigen};
  if (SparseCholesky::has_cholmod()) list.push_back(CholeskyBackend::Cholmod);
  return list;
}

}  // namespace batten::fixtures
