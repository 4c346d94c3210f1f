#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/surfacing/fairing_detail.hpp"

namespace batten::detail {

namespace {

/// Fixed vertices are unknowns too where they are constrained softly.
HeldUnknowns held_of(const std::vector<char>& fixed, bool soft) {
  return HeldUnknowns(soft ? std::vector<char>(fixed.size(), 0) : fixed);
}

/// PatchSystems::cost() at which one factor of the bi-Laplacian of all patches takes as long. Seen on spheres
/// of 8 and tori of 12 and 56 patches with 7,000 to 170,000 triangles: nested dissection and supernodes are
/// as fast from some 15,000 multiplications per unknown on, Eigen's factor five times slower at 6,500.
double cost_of_whole(Eigen::Index unknowns) {
  const bool with_cholmod = SparseCholesky::has_cholmod() && unknowns > SparseCholesky::kCholmodFrom;
  return (with_cholmod ? 15e3 : 50e3) * static_cast<double>(unknowns);
}

/// Of ∫|r|² beside ∫|∇r|², lengths in diameters: a wave as long as the object has 40 times as much of the
/// latter.
constexpr double kShareOfLaplacian = 1e-3;

/// Unknowns from which CHOLMOD is faster in the system of sixth order: its factor is three times as full as
/// those that CholeskyBackend::Auto was measured on.
constexpr Eigen::Index kSupernodesFrom = 3000;

/// The stiffness of the edges between vertices whose row is kept; 0 elsewhere.
SparseMatrix kept_stiffness(const SparseMatrix& K, const Eigen::VectorXd& inverse_mass) {
  SparseMatrix kept = K;
  for (int v = 0; v < kept.outerSize(); ++v) {
    double sum = 0;
    double* diagonal = nullptr;
    for (SparseMatrix::InnerIterator entry(kept, v); entry; ++entry) {
      if (entry.row() == v)
        diagonal = &entry.valueRef();
      else if (inverse_mass[v] == 0 || inverse_mass[entry.row()] == 0)
        entry.valueRef() = 0;
      else
        sum += entry.value();
    }
    if (diagonal != nullptr) *diagonal = -sum;
  }
  return kept;
}

}  // namespace

FairingSystems::FairingSystems(const std::vector<char>& fixed, std::vector<char> border,
                               Eigen::VectorXd soft_weights, FairingFactors factors)
    : unknowns_(held_of(fixed, soft_weights.size() > 0)),
      border_(std::move(border)),
      soft_weights_(std::move(soft_weights)),
      factors_(factors) {
  systems_[0] = std::make_unique<HeldSolver>("the harmonic system of the surface", unknowns_);
  systems_[1] = std::make_unique<HeldSolver>("the biharmonic system of the surface", unknowns_);
  systems_[2] = std::make_unique<HeldSolver>("the triharmonic system of the surface", unknowns_);
  const bool is_large = SparseCholesky::has_cholmod() && unknowns_.n_free() > kSupernodesFrom;
  gradient_system_ =
      std::make_unique<HeldSolver>("the system of the normals of the surface", unknowns_,
                                   is_large ? CholeskyBackend::Cholmod : CholeskyBackend::Auto);
}

void FairingSystems::set_metric(const Triangles& triangles, const EdgeLengths& lengths) {
  const Eigen::Index n = unknowns_.size();
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
  std::fill(std::begin(ready_), std::end(ready_), false);
  patches_ready_ = false;
  gradient_ready_ = false;
}

PatchSystems* FairingSystems::patches() {
  if (factors_ == FairingFactors::Whole || soft_weights_.size() > 0) return nullptr;
  if (patches_ready_) return patches_.get();
  patches_ready_ = true;
  // Without its row a free vertex would have nothing but the rows around it.
  const auto has_no_row = [&](int v) { return inverse_mass_[v] == 0; };
  if (std::any_of(unknowns_.free().begin(), unknowns_.free().end(), has_no_row)) return nullptr;
  if (!patches_) patches_ = std::make_unique<PatchSystems>(K_, unknowns_);
  if (factors_ == FairingFactors::Auto && patches_->cost() > cost_of_whole(unknowns_.n_free())) {
    patches_.reset();
    factors_ = FairingFactors::Whole;  // which depends on the triangles alone
    return nullptr;
  }
  try {
    patches_->factorize(K_, mass_, inverse_mass_);
  } catch (const SolverFailure&) {
    // Needles at the bound of their cotangents can make the stiffness of a patch indefinite, which its square
    // is not.
    if (factors_ == FairingFactors::Patches) throw;
    patches_.reset();
  }
  return patches_.get();
}

void FairingSystems::prepare(int order) {
  if (ready_[order - 1]) return;
  SparseMatrix lower, coupling;
  if (order == 2) {
    SquaredStiffness squared =
        squared_stiffness(K_, inverse_mass_, unknowns_.free_index(), unknowns_.held_index());
    lower.swap(squared.lower);
    coupling.swap(squared.known);
  } else {
    SparseMatrix whole = K_;
    if (order == 3)
      whole = SparseMatrix(K_ * inverse_mass_.asDiagonal()) * K_ * inverse_mass_.asDiagonal() * K_;
    lower = unknowns_.free_block(whole, true);
    coupling = unknowns_.coupling(whole);
  }
  if (soft_weights_.size() > 0)
    for (Eigen::Index i = 0; i < unknowns_.n_free(); ++i)
      lower.coeffRef(i, i) += soft_weights_[unknowns_.free()[at(i)]];
  systems_[order - 1]->factorize(lower, std::move(coupling));
  ready_[order - 1] = true;
}

Eigen::MatrixXd FairingSystems::solve(int order, Eigen::MatrixXd right_side, const Eigen::MatrixXd& values) {
  prepare(order);
  if (soft_weights_.size() > 0) right_side += soft_weights_.asDiagonal() * values;
  return systems_[order - 1]->solve(right_side, values);
}

Eigen::MatrixXd FairingSystems::polyharmonic(int order, const Eigen::MatrixXd& values) {
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(values.rows(), values.cols());
  PatchSystems* const parts = order <= 2 ? patches() : nullptr;
  if (parts != nullptr) return order == 1 ? parts->harmonic(zero, values) : parts->biharmonic(zero, values);
  return solve(order, zero, values);
}

Eigen::MatrixXd FairingSystems::fit_laplacian(const Eigen::MatrixXd& target, const Eigen::MatrixXd& values) {
  if (PatchSystems* const parts = patches()) return parts->biharmonic(target, values);
  return solve(2, K_ * (inverse_mass_.asDiagonal() * target), values);
}

Eigen::MatrixXd FairingSystems::fit_laplacian_gradient(const Eigen::MatrixXd& target,
                                                       const Eigen::MatrixXd& values) {
  if (!gradient_ready_) {
    const Eigen::VectorXd& D = inverse_mass_;
    SparseMatrix energy = D.asDiagonal() * kept_stiffness(K_, D) * D.asDiagonal();
    energy.diagonal() += kShareOfLaplacian * D;
    gradient_rows_ = K_ * energy;
    const SparseMatrix whole = gradient_rows_ * K_;
    gradient_system_->factorize(unknowns_.free_block(whole, true), unknowns_.coupling(whole));
    gradient_ready_ = true;
  }
  return gradient_system_->solve(gradient_rows_ * target, values);
}

Eigen::MatrixXd FairingSystems::biharmonic_with_curvature(const Eigen::MatrixXd& curvature_vectors,
                                                          const Eigen::MatrixXd& values) {
  const auto harmonic = [&](const Eigen::MatrixXd& right_side, const Eigen::MatrixXd& given) {
    if (const PatchSystems* const parts = patches()) return parts->harmonic(right_side, given);
    return solve(1, right_side, given);
  };
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(values.rows(), values.cols());
  return harmonic(mass_.asDiagonal() * harmonic(zero, curvature_vectors), values);
}

void normalize_propagated(Points& normals, const SparseMatrix& adjacency, const std::vector<int>& vertices) {
  std::vector<int> vanished;
  for (const int v : vertices) {
    const double length = normals.row(v).norm();
    if (length > 1e-6)
      normals.row(v) /= length;
    else
      vanished.push_back(v);
  }
  if (vanished.empty()) return;
  const Points sound = normals;
  std::vector<char> is_vanished(static_cast<std::size_t>(normals.rows()), 0);
  for (const int v : vanished) is_vanished[at(v)] = 1;
  for (const int v : vanished) {
    std::vector<char> seen(is_vanished.size(), 0);
    std::vector<int> ring = {v}, next;
    seen[at(v)] = 1;
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    while (sum.norm() < 1e-6 && !ring.empty()) {
      next.clear();
      for (const int w : ring)
        for (SparseMatrix::InnerIterator edge(adjacency, w); edge; ++edge) {
          const auto u = static_cast<std::size_t>(edge.row());
          if (std::exchange(seen[u], 1)) continue;
          next.push_back(static_cast<int>(u));
          if (!is_vanished[u]) sum += sound.row(edge.row());
        }
      ring.swap(next);
    }
    normals.row(v) = sum.norm() > 0 ? Eigen::RowVector3d(sum.normalized()) : Eigen::RowVector3d(0, 0, 1);
  }
}

void normalize_propagated(Points& normals, const SparseMatrix& adjacency) {
  std::vector<int> all(static_cast<std::size_t>(normals.rows()));
  std::iota(all.begin(), all.end(), 0);
  normalize_propagated(normals, adjacency, all);
}

double curvature_along_edges(const SparseMatrix& K, const Points& positions, const Points& normals,
                             Eigen::Index vertex) {
  double curvature = 0;
  for (SparseMatrix::InnerIterator edge(K, vertex); edge; ++edge)
    if (edge.row() != vertex)
      curvature -= 0.5 * edge.value() *
                   (normals.row(edge.row()) - normals.row(vertex))
                       .dot(positions.row(edge.row()) - positions.row(vertex));
  return curvature;
}

Eigen::VectorXd curvature_along_edges(const SparseMatrix& K, const Points& positions, const Points& normals) {
  Eigen::VectorXd curvature(K.rows());
  for (Eigen::Index v = 0; v < K.rows(); ++v) curvature[v] = curvature_along_edges(K, positions, normals, v);
  return curvature;
}

void curvature_target(const FairingSystems& systems, const Triangles& around, bool metric_from_layout,
                      const Points& positions, const Points& normals, const std::vector<int>& vertices,
                      Points& target) {
  if (metric_from_layout) {
    const Points vectors = integrated_curvature_from_normals(positions, normals, around);
    for (const int v : vertices) target.row(v) = -vectors.row(v).dot(normals.row(v)) * normals.row(v);
  } else {
    for (const int v : vertices)
      target.row(v) = curvature_along_edges(systems.stiffness(), positions, normals, v) * normals.row(v);
  }
}

Points curvature_target(const FairingSystems& systems, const Triangles& triangles, bool metric_from_layout,
                        const Points& positions, const Points& normals) {
  std::vector<int> all(static_cast<std::size_t>(positions.rows()));
  std::iota(all.begin(), all.end(), 0);
  Points target(positions.rows(), 3);
  curvature_target(systems, triangles, metric_from_layout, positions, normals, all, target);
  return target;
}

bool is_folded(const Points& X, const Points& N, const Triangles& triangles, Eigen::Index triangle) {
  const int i = triangles(triangle, 0), j = triangles(triangle, 1), k = triangles(triangle, 2);
  const Eigen::RowVector3d a = X.row(i), b = X.row(j), c = X.row(k);
  return (b - a).cross(c - a).dot(N.row(i) + N.row(j) + N.row(k)) < 0;
}

std::vector<int> all_folded(const Points& X, const Points& N, const Triangles& triangles) {
  std::vector<int> folded;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    if (is_folded(X, N, triangles, f)) folded.push_back(static_cast<int>(f));
  return folded;
}

std::vector<double> folded_shares(const Points& X, const Points& N, const Triangles& triangles,
                                  const std::vector<int>& patch_of_triangle, std::size_t n_patches) {
  std::vector<double> folded(n_patches, 0), area(n_patches, 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Eigen::RowVector3d a = X.row(triangles(f, 0)), b = X.row(triangles(f, 1)),
                             c = X.row(triangles(f, 2));
    const double size = (b - a).cross(c - a).norm();
    const std::size_t p = at(patch_of_triangle[at(f)]);
    area[p] += size;
    if (is_folded(X, N, triangles, f)) folded[p] += size;
  }
  for (std::size_t p = 0; p < n_patches; ++p)
    if (area[p] > 0) folded[p] /= area[p];
  return folded;
}

Soundness soundness_of(const Points& X, const Points& N, const Triangles& triangles,
                       const std::vector<int>& chosen) {
  Soundness s;
  const double least2 = std::pow(std::sin(radians(0.5)), 2);
  for (const int f : chosen) {
    const Eigen::RowVector3d a = X.row(triangles(f, 0)), b = X.row(triangles(f, 1)),
                             c = X.row(triangles(f, 2));
    const double sides2[3] = {(c - b).squaredNorm(), (a - c).squaredNorm(), (b - a).squaredNorm()};
    // The two longest sides enclose the smallest angle; the area is half its sine times both.
    const double shortest2 = std::min({sides2[0], sides2[1], sides2[2]});
    const double longer2 = shortest2 > 0 ? sides2[0] * sides2[1] * sides2[2] / shortest2 : 0;
    if (!((b - a).cross(c - a).squaredNorm() > least2 * longer2)) ++s.degenerate;
    if (is_folded(X, N, triangles, f)) ++s.folded;
  }
  return s;
}

Soundness soundness_of(const Points& X, const Points& N, const Triangles& triangles) {
  std::vector<int> all(static_cast<std::size_t>(triangles.rows()));
  std::iota(all.begin(), all.end(), 0);
  return soundness_of(X, N, triangles, all);
}

}  // namespace batten::detail
