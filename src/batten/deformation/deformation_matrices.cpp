#include <algorithm>

#include "batten/core/disjoint_sets.hpp"
#include "batten/deformation/deformation_matrices_detail.hpp"

namespace batten::detail {

std::vector<int> connected_parts(const Triangles& triangles, Eigen::Index n) {
  DisjointSets sets(static_cast<int>(n));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 2; ++k) sets.unite(triangles(f, k), triangles(f, k + 1));
  std::vector<int> lowest(n);
  for (Eigen::Index v = 0; v < n; ++v) lowest[v] = sets.root(static_cast<int>(v));
  return lowest;
}

EdgeLengths mollified(EdgeLengths lengths) {
  if (lengths.rows() == 0) return lengths;
  const double least = 1e-2 * lengths.mean();
  double add = 0;
  for (Eigen::Index f = 0; f < lengths.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      add = std::max(add, least + lengths(f, k) - lengths(f, (k + 1) % 3) - lengths(f, (k + 2) % 3));
  lengths.array() += add;
  return lengths;
}

void clamp_weights(SparseMatrix& K) {
  for (Eigen::Index i = 0; i < K.cols(); ++i) {
    double sum = 0;
    double* diagonal = nullptr;
    for (SparseMatrix::InnerIterator entry(K, i); entry; ++entry) {
      if (entry.row() == i) {
        diagonal = &entry.valueRef();
        continue;
      }
      entry.valueRef() = std::min(entry.value(), 0.0);
      sum += entry.value();
    }
    if (diagonal != nullptr) *diagonal = -sum;
  }
}

SparseMatrix weighted_stiffness(const SparseMatrix& K, const Eigen::VectorXd& g) {
  SparseMatrix weighted = K;  // NOLINT(performance-unnecessary-copy-initialization): iterators write into it
  for (Eigen::Index i = 0; i < K.cols(); ++i) {
    double sum = 0;
    double* diagonal = nullptr;
    for (SparseMatrix::InnerIterator entry(weighted, i); entry; ++entry) {
      if (entry.row() == i) {
        diagonal = &entry.valueRef();
        continue;
      }
      entry.valueRef() *= 0.5 * (g[i] + g[entry.row()]);
      sum += entry.value();
    }
    if (diagonal != nullptr) *diagonal = -sum;
  }
  return weighted;
}

SparseMatrix part_of(const SparseMatrix& T, const std::vector<int>& row_of, const std::vector<int>& column_of,
                     Eigen::Index n_rows, Eigen::Index n_columns, bool lower) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < T.cols(); ++i)
    for (SparseMatrix::InnerIterator entry(T, i); entry; ++entry) {
      const int row = row_of[entry.row()], column = column_of[i];
      if (row >= 0 && column >= 0 && (!lower || row >= column))
        entries.emplace_back(row, column, entry.value());
    }
  SparseMatrix part(n_rows, n_columns);
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

}  // namespace batten::detail
