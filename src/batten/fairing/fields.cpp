#include <algorithm>

#include "batten/core/parallel.hpp"
#include "batten/fairing/fields_detail.hpp"

namespace batten::fairing_detail {

using Eigen::VectorXd;

MeshFields::MeshFields(const Triangles& triangles, Eigen::Index n_vertices)
    : triangles_(triangles),
      n_(n_vertices),
      around_(triangles_of_vertices(triangles, n_vertices)),
      neighbours_(vertex_neighbours(triangles, n_vertices)),
      slots_(6 * static_cast<std::size_t>(triangles.rows())) {
  const auto place = [&](int row, int column) {
    const auto begin = neighbours_.indices.begin();
    return static_cast<int>(
        std::lower_bound(begin + neighbours_.begin(row), begin + neighbours_.end(row), column) - begin);
  };
  parallel_for(triangles.rows(), kTriangleGrain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index f = begin; f < end; ++f)
      for (int k = 0; k < 3; ++k) {
        const int i = triangles(f, (k + 1) % 3), j = triangles(f, (k + 2) % 3);
        slots_[6 * f + 2 * k] = place(i, j);
        slots_[6 * f + 2 * k + 1] = place(j, i);
      }
  });
}

VectorXd MeshFields::ring_mean(const VectorXd& field) const {
  VectorXd mean(n_);
  parallel_for(n_, kVertexGrain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index v = begin; v < end; ++v) {
      double sum = field[v];
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i) sum += field[neighbours_.indices[i]];
      mean[v] = sum / (1 + neighbours_.size(v));
    }
  });
  return mean;
}

VectorXd MeshFields::without_mean(const VectorXd& field) const {
  VectorXd rest = VectorXd::Zero(n_);
  parallel_for(n_, kVertexGrain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index v = begin; v < end; ++v) {
      if (neighbours_.size(v) == 0) continue;
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i)
        rest[v] += field[v] - field[neighbours_.indices[i]];
      rest[v] /= neighbours_.size(v);
    }
  });
  return rest;
}

void MeshFields::multiply(const EdgeMatrix& A, const VectorXd& x, VectorXd& y) const {
  y.resize(n_);
  parallel_for(n_, kVertexGrain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index v = begin; v < end; ++v) {
      double sum = A.diagonal[v] * x[v];
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i)
        sum += A.off_diagonal[i] * x[neighbours_.indices[i]];
      y[v] = sum;
    }
  });
}

}  // namespace batten::fairing_detail
