#include "batten/operators/laplacian.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

struct MatrixEntry {
  int row;
  double value;
};

/// Stable. A vertex has a dozen entries: std::stable_sort would ask for memory at every one.
void sort_by_row(MatrixEntry* first, MatrixEntry* last) {
  const auto before = [](const MatrixEntry& a, const MatrixEntry& b) { return a.row < b.row; };
  if (last - first > 64) {
    std::stable_sort(first, last, before);
    return;
  }
  for (MatrixEntry* next = first; next != last; ++next) {
    const MatrixEntry entry = *next;
    MatrixEntry* place = next;
    for (; place != first && before(entry, *(place - 1)); --place) *place = *(place - 1);
    *place = entry;
  }
}

/// Symmetric matrix of n rows with zero row sums and the off-diagonal −weight(h) added at both ends of every
/// half-edge h = 3f + k. Built by counting, without triplets: assembly is a visible part of surfacing.
template <typename Weight>
SparseMatrix graph_matrix(const Triangles& triangles, Eigen::Index n, const Weight& weight) {
  const Eigen::Index m = triangles.rows();
  std::vector<int> start(static_cast<std::size_t>(n) + 1, 0);
  for (Eigen::Index f = 0; f < m; ++f)
    for (int k = 0; k < 3; ++k) {
      const int v = triangles(f, k);
      if (v < 0 || v >= n)
        throw InvalidInput(
            concat("triangle ", f, " names vertex ", v, ", but the mesh has the vertices 0 to ", n - 1));
      start[v + 1] += 2;
    }
  for (Eigen::Index v = 0; v < n; ++v) start[v + 1] += start[v];
  using Entry = MatrixEntry;
  std::vector<Entry> entries(6 * static_cast<std::size_t>(m));
  std::vector<int> fill(start.begin(), start.end() - 1);
  for (Eigen::Index f = 0; f < m; ++f)
    for (int k = 0; k < 3; ++k) {
      const int i = triangles(f, (k + 1) % 3), j = triangles(f, (k + 2) % 3);
      const double w = weight(f, k);
      entries[fill[i]++] = {j, w};
      entries[fill[j]++] = {i, w};
    }
  SparseMatrix K(n, n);
  std::vector<int> count(n);
  for (Eigen::Index v = 0; v < n; ++v) {
    Entry* const first = entries.data() + start[v];
    Entry* const last = entries.data() + start[v + 1];
    sort_by_row(first, last);
    Entry* out = first;
    for (Entry* e = first; e != last; ++e)
      if (out != first && (out - 1)->row == e->row)
        (out - 1)->value += e->value;
      else
        *out++ = *e;
    count[v] = static_cast<int>(out - first);
  }
  Eigen::Index non_zeros = 0;
  int* outer = K.outerIndexPtr();
  for (Eigen::Index v = 0; v < n; ++v) {
    outer[v] = static_cast<int>(non_zeros);
    non_zeros += count[v] + 1;
  }
  outer[n] = static_cast<int>(non_zeros);
  K.resizeNonZeros(non_zeros);
  for (Eigen::Index v = 0; v < n; ++v) {
    int at = outer[v];
    double sum = 0;
    for (int e = 0; e < count[v]; ++e) sum += entries[start[v] + e].value;
    bool placed = false;
    for (int e = 0; e < count[v]; ++e) {
      const Entry& entry = entries[start[v] + e];
      if (!placed && entry.row > v) {
        K.innerIndexPtr()[at] = static_cast<int>(v);
        K.valuePtr()[at++] = sum;
        placed = true;
      }
      K.innerIndexPtr()[at] = entry.row;
      K.valuePtr()[at++] = -entry.value;
    }
    if (!placed) {
      K.innerIndexPtr()[at] = static_cast<int>(v);
      K.valuePtr()[at] = sum;
    }
  }
  return K;
}

}  // namespace

std::optional<std::string> CotangentOptions::problem() const {
  if (!(bound > 0) || !std::isfinite(bound)) return concat("bound must be finite and above 0, got ", bound);
  return std::nullopt;
}

SparseMatrix cotangent_stiffness(const Triangles& triangles, const EdgeLengths& lengths,
                                 Eigen::Index n_vertices, const CotangentOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  Points cotangents(triangles.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const double a = lengths(f, 0), b = lengths(f, 1), c = lengths(f, 2);
    const double area = triangle_area(a, b, c);
    const double squares[3] = {b * b + c * c - a * a, c * c + a * a - b * b, a * a + b * b - c * c};
    for (int k = 0; k < 3; ++k) {
      // A triangle of no area has angles 0, 0 and π; the bound stands for their infinite cotangents.
      const double cotangent =
          area > 0 ? squares[k] / (4 * area) : (squares[k] < 0 ? -options.bound : options.bound);
      cotangents(f, k) = std::clamp(cotangent, -options.bound, options.bound);
    }
  }
  return graph_matrix(triangles, n_vertices, [&](Eigen::Index f, int k) { return 0.5 * cotangents(f, k); });
}

SparseMatrix cotangent_stiffness(const Points& positions, const Triangles& triangles) {
  return cotangent_stiffness(triangles, edge_lengths(positions, triangles), positions.rows());
}

SparseMatrix uniform_stiffness(const Triangles& triangles, Eigen::Index n_vertices) {
  // Every edge once: an inner edge is seen from both of its triangles.
  const std::vector<int> opposite = opposite_half_edges(triangles);
  return graph_matrix(triangles, n_vertices, [&](Eigen::Index f, int k) {
    return opposite[static_cast<std::size_t>(3 * f + k)] < 0 ? 1.0 : 0.5;
  });
}

Eigen::VectorXd lumped_mass(const Triangles& triangles, const EdgeLengths& lengths, Eigen::Index n_vertices,
                            MassKind kind) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(n_vertices);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    double squared[3];
    for (int k = 0; k < 3; ++k) squared[k] = lengths(f, k) * lengths(f, k);
    const double area = triangle_area(lengths(f, 0), lengths(f, 1), lengths(f, 2));
    const double sum = squared[0] + squared[1] + squared[2];
    int obtuse = -1;
    for (int k = 0; k < 3; ++k)
      if (2 * squared[k] > sum) obtuse = k;
    for (int k = 0; k < 3; ++k) {
      double share = area / 3;
      if (kind == MassKind::MixedVoronoi && obtuse >= 0)
        share = k == obtuse ? area / 2 : area / 4;
      else if (kind == MassKind::MixedVoronoi && area > 0) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        // (cot of the angle at i) |edge opposite i|² + the same for j, over 8.
        share = (squared[i] * (sum - 2 * squared[i]) + squared[j] * (sum - 2 * squared[j])) / (32 * area);
      }
      mass[triangles(f, k)] += share;
    }
  }
  return mass;
}

Eigen::VectorXd lumped_mass(const Points& positions, const Triangles& triangles, MassKind kind) {
  return lumped_mass(triangles, edge_lengths(positions, triangles), positions.rows(), kind);
}

SquaredStiffness squared_stiffness(const SparseMatrix& K, const Eigen::VectorXd& d,
                                   const std::vector<int>& index_of_unknown,
                                   const std::vector<int>& index_of_known) {
  const Eigen::Index n = K.rows();
  Eigen::Index n_unknowns = 0, n_knowns = 0;
  for (const int i : index_of_unknown) n_unknowns = std::max<Eigen::Index>(n_unknowns, i + 1);
  for (const int i : index_of_known) n_knowns = std::max<Eigen::Index>(n_knowns, i + 1);
  // A column of the product is a combination of the columns of K at the neighbours of its vertex.
  const auto fill = [&](const std::vector<int>& index_of_column, Eigen::Index n_columns, bool lower) {
    std::vector<int> vertex_of_column(n_columns, -1);
    for (Eigen::Index v = 0; v < n; ++v)
      if (index_of_column[v] >= 0) vertex_of_column[index_of_column[v]] = static_cast<int>(v);
    SparseMatrix product(n_unknowns, n_columns);
    std::vector<int> rows;
    std::vector<double> values, sums(n_unknowns, 0.0);
    std::vector<char> touched(n_unknowns, 0);
    std::vector<int> pattern;
    rows.reserve(static_cast<std::size_t>(n_columns) * (lower ? 10 : 8));
    values.reserve(rows.capacity());
    for (Eigen::Index column = 0; column < n_columns; ++column) {
      product.outerIndexPtr()[column] = static_cast<int>(rows.size());
      const int v = vertex_of_column[column];
      if (v < 0) continue;
      pattern.clear();
      for (SparseMatrix::InnerIterator middle(K, v); middle; ++middle) {
        const double factor = d[middle.row()] * middle.value();
        if (d[middle.row()] == 0) continue;
        for (SparseMatrix::InnerIterator far(K, middle.row()); far; ++far) {
          const int row = index_of_unknown[far.row()];
          if (row < 0 || (lower && row < column)) continue;
          if (!touched[row]) {
            touched[row] = 1;
            pattern.push_back(row);
          }
          sums[row] += factor * far.value();
        }
      }
      std::sort(pattern.begin(), pattern.end());
      for (const int row : pattern) {
        rows.push_back(row);
        values.push_back(sums[row]);
        sums[row] = 0;
        touched[row] = 0;
      }
    }
    product.outerIndexPtr()[n_columns] = static_cast<int>(rows.size());
    product.resizeNonZeros(static_cast<Eigen::Index>(rows.size()));
    std::copy(rows.begin(), rows.end(), product.innerIndexPtr());
    std::copy(values.begin(), values.end(), product.valuePtr());
    return product;
  };
  SquaredStiffness result;
  result.lower = fill(index_of_unknown, n_unknowns, true);
  result.known = fill(index_of_known, n_knowns, false);
  return result;
}

}  // namespace batten
