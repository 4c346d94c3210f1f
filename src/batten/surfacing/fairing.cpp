#include <algorithm>

#include <Eigen/Dense>

#include "batten/operators/curvature.hpp"
#include "batten/surfacing/fairing_detail.hpp"

namespace batten::detail {

FairingSystems::FairingSystems(std::vector<char> fixed, std::vector<char> border,
                               Eigen::VectorXd soft_weights)
    : fixed_(std::move(fixed)), border_(std::move(border)), soft_weights_(std::move(soft_weights)) {
  const std::size_t n = fixed_.size();
  unknown_.assign(n, -1);
  known_.assign(n, -1);
  for (std::size_t v = 0; v < n; ++v)
    if (fixed_[v] && soft_weights_.size() == 0) {
      known_[v] = static_cast<int>(vertex_of_known_.size());
      vertex_of_known_.push_back(static_cast<int>(v));
    } else {
      unknown_[v] = static_cast<int>(vertex_of_unknown_.size());
      vertex_of_unknown_.push_back(static_cast<int>(v));
    }
  systems_[0] = std::make_unique<System>("the harmonic system of the surface");
  systems_[1] = std::make_unique<System>("the biharmonic system of the surface");
  systems_[2] = std::make_unique<System>("the triharmonic system of the surface");
}

void FairingSystems::set_metric(const Triangles& triangles, const EdgeLengths& lengths) {
  const auto n = static_cast<Eigen::Index>(fixed_.size());
  // The bound keeps the weights of a needle finite: 50 is an angle of 1.1°.
  K_ = cotangent_stiffness(triangles, lengths, n, {50});
  mass_ = lumped_mass(triangles, lengths, n);
  // A vertex whose triangles have collapsed still needs a finite weight.
  const double least = 1e-6 * mass_.sum() / static_cast<double>(std::max<Eigen::Index>(n, 1));
  inverse_mass_ = Eigen::VectorXd::Zero(n);
  for (Eigen::Index v = 0; v < n; ++v) {
    mass_[v] = std::max(mass_[v], least);
    if (!border_[v]) inverse_mass_[v] = 1 / mass_[v];
  }
  for (auto& system : systems_) system->ready = false;
}

void FairingSystems::prepare(int order) {
  System& s = system(order);
  if (s.ready) return;
  const auto n_unknown = static_cast<Eigen::Index>(vertex_of_unknown_.size());
  const auto n_known = static_cast<Eigen::Index>(vertex_of_known_.size());
  SparseMatrix lower;
  if (order == 2) {
    SquaredStiffness squared = squared_stiffness(K_, inverse_mass_, unknown_, known_);
    lower.swap(squared.lower);
    s.known.swap(squared.known);
  } else {
    SparseMatrix whole = K_;
    if (order == 3)
      whole = SparseMatrix(K_ * inverse_mass_.asDiagonal()) * K_ * inverse_mass_.asDiagonal() * K_;
    std::vector<Eigen::Triplet<double>> inner, outer;
    for (Eigen::Index column = 0; column < whole.outerSize(); ++column)
      for (SparseMatrix::InnerIterator entry(whole, column); entry; ++entry) {
        const int i = unknown_[entry.row()], j = unknown_[column];
        if (i < 0) continue;
        if (j >= 0 && i >= j) inner.emplace_back(i, j, entry.value());
        if (j < 0) outer.emplace_back(i, known_[column], entry.value());
      }
    lower.resize(n_unknown, n_unknown);
    lower.setFromTriplets(inner.begin(), inner.end());
    s.known.resize(n_unknown, n_known);
    s.known.setFromTriplets(outer.begin(), outer.end());
  }
  if (soft_weights_.size() > 0)
    for (Eigen::Index i = 0; i < n_unknown; ++i) lower.coeffRef(i, i) += soft_weights_[vertex_of_unknown_[i]];
  s.factor.factorize(lower);
  s.ready = true;
}

Eigen::MatrixXd FairingSystems::solve(int order, const Eigen::MatrixXd& right_side,
                                      const Eigen::MatrixXd& values) {
  prepare(order);
  const auto n_unknown = static_cast<Eigen::Index>(vertex_of_unknown_.size());
  const auto n_known = static_cast<Eigen::Index>(vertex_of_known_.size());
  Eigen::MatrixXd B(n_unknown, values.cols()), known(n_known, values.cols());
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    for (Eigen::Index i = 0; i < n_unknown; ++i) B(i, c) = right_side(vertex_of_unknown_[i], c);
    if (soft_weights_.size() > 0)
      for (Eigen::Index i = 0; i < n_unknown; ++i)
        B(i, c) += soft_weights_[vertex_of_unknown_[i]] * values(vertex_of_unknown_[i], c);
    for (Eigen::Index i = 0; i < n_known; ++i) known(i, c) = values(vertex_of_known_[i], c);
  }
  if (n_known > 0) B -= system(order).known * known;
  const Eigen::MatrixXd X = system(order).factor.solve(B);
  Eigen::MatrixXd result = values;
  for (Eigen::Index c = 0; c < values.cols(); ++c)
    for (Eigen::Index i = 0; i < n_unknown; ++i) result(vertex_of_unknown_[i], c) = X(i, c);
  return result;
}

Eigen::MatrixXd FairingSystems::polyharmonic(int order, const Eigen::MatrixXd& values) {
  return solve(order, Eigen::MatrixXd::Zero(values.rows(), values.cols()), values);
}

Eigen::MatrixXd FairingSystems::fit_laplacian(const Eigen::MatrixXd& target, const Eigen::MatrixXd& values) {
  return solve(2, K_ * (inverse_mass_.asDiagonal() * target), values);
}

Eigen::MatrixXd FairingSystems::biharmonic_with_curvature(const Eigen::MatrixXd& curvature_vectors,
                                                          const Eigen::MatrixXd& values) {
  const Eigen::MatrixXd harmonic =
      solve(1, Eigen::MatrixXd::Zero(values.rows(), values.cols()), curvature_vectors);
  return solve(1, mass_.asDiagonal() * harmonic, values);
}

void normalize_propagated(Points& normals, const SparseMatrix& adjacency) {
  const Eigen::Index n = normals.rows();
  std::vector<Eigen::Index> vanished;
  for (Eigen::Index v = 0; v < n; ++v) {
    const double length = normals.row(v).norm();
    if (length > 1e-6)
      normals.row(v) /= length;
    else
      vanished.push_back(v);
  }
  if (vanished.empty()) return;
  const Points sound = normals;
  std::vector<char> is_vanished(n, 0);
  for (const Eigen::Index v : vanished) is_vanished[v] = 1;
  for (const Eigen::Index v : vanished) {
    std::vector<char> seen(n, 0);
    std::vector<Eigen::Index> ring = {v}, next;
    seen[v] = 1;
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    while (sum.norm() < 1e-6 && !ring.empty()) {
      next.clear();
      for (const Eigen::Index w : ring)
        for (SparseMatrix::InnerIterator edge(adjacency, w); edge; ++edge)
          if (!seen[edge.row()]) {
            seen[edge.row()] = 1;
            next.push_back(edge.row());
            if (!is_vanished[edge.row()]) sum += sound.row(edge.row());
          }
      ring.swap(next);
    }
    normals.row(v) = sum.norm() > 0 ? Eigen::RowVector3d(sum.normalized()) : Eigen::RowVector3d(0, 0, 1);
  }
}

Eigen::VectorXd curvature_along_edges(const SparseMatrix& K, const Points& positions, const Points& normals) {
  Eigen::VectorXd curvature = Eigen::VectorXd::Zero(K.rows());
  for (Eigen::Index i = 0; i < K.outerSize(); ++i)
    for (SparseMatrix::InnerIterator edge(K, i); edge; ++edge)
      if (edge.row() != i)
        curvature[i] -=
            0.5 * edge.value() *
            (normals.row(edge.row()) - normals.row(i)).dot(positions.row(edge.row()) - positions.row(i));
  return curvature;
}

bool is_folded(const Points& X, const Points& N, const Triangles& triangles, Eigen::Index triangle) {
  const int i = triangles(triangle, 0), j = triangles(triangle, 1), k = triangles(triangle, 2);
  const Eigen::RowVector3d a = X.row(i), b = X.row(j), c = X.row(k);
  return (b - a).cross(c - a).dot(N.row(i) + N.row(j) + N.row(k)) < 0;
}

}  // namespace batten::detail
