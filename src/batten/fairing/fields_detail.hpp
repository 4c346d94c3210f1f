#pragma once
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/fairing/neighbours_detail.hpp"

namespace batten::fairing_detail {

/// Triangles per chunk of a parallel loop over them, and vertices: some 0.1 ms of work.
constexpr Eigen::Index kTriangleGrain = 2048, kVertexGrain = 2048;

/// A symmetric matrix of the pattern of a mesh: its diagonal, and the entries of the edges in the order of
/// the neighbours of each vertex.
struct EdgeMatrix {
  Eigen::VectorXd diagonal;
  std::vector<double> off_diagonal;
};

/// The connectivity of a mesh, and what it does to values at its vertices. Loops are parallel and give the
/// same bits on any number of threads: every vertex adds up its own sums, in the order of its triangles or
/// neighbours.
class MeshFields {
 public:
  MeshFields(const Triangles& triangles, Eigen::Index n_vertices);

  Eigen::Index n_vertices() const { return n_; }
  const IndexLists& around() const { return around_; }          ///< triangles of each vertex, ascending
  const IndexLists& neighbours() const { return neighbours_; }  ///< of each vertex, ascending

  /// The mean over each vertex and its neighbours.
  Eigen::VectorXd ring_mean(const Eigen::VectorXd& field) const;
  /// (I − P) field, with P the mean of the neighbours alone.
  Eigen::VectorXd without_mean(const Eigen::VectorXd& field) const;
  /// y = A x.
  void multiply(const EdgeMatrix& A, const Eigen::VectorXd& x, Eigen::VectorXd& y) const;

  /// Calls visit(v, f, corner) at every vertex v for each of its triangles f, v being that corner of it.
  /// Calls of one vertex come from one thread, in the order of the triangles.
  template <typename Visit>
  void visit_corners(Eigen::Index begin, Eigen::Index end, Visit&& visit) const {
    for (Eigen::Index v = begin; v < end; ++v)
      for (int i = around_.begin(v); i < around_.end(v); ++i) {
        const int f = around_.indices[i];
        visit(v, f, triangles_(f, 0) == v ? 0 : triangles_(f, 1) == v ? 1 : 2);
      }
  }
  /// The place of the edge opposite corner k of triangle f in the lists of neighbours: `reverse` false in the
  /// row of its start (corner k + 1), true in that of its end.
  int slot(Eigen::Index f, int k, bool reverse) const {
    return slots_[static_cast<std::size_t>(6 * f + 2 * k + (reverse ? 1 : 0))];
  }

 private:
  const Triangles& triangles_;
  Eigen::Index n_;
  IndexLists around_, neighbours_;
  std::vector<int> slots_;
};

}  // namespace batten::fairing_detail
