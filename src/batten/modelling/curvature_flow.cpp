// Based on H 6.4: STEP 1 and STEP 2 of 6.4.1, with the scalar form of (6.3) and the signs of
// docs/departures.md.
#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/modelling/curvature_flow_detail.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// No triangle may turn by more than 60° or lose more than four fifths of its area in one round.
constexpr double kLeastTurn = 0.5, kLeastShrink = 0.2;

}  // namespace

Eigen::VectorXd bounded_mass(const Eigen::VectorXd& mass) {
  const double least = 1e-3 * mass.mean();
  return mass.cwiseMax(least);
}

CurvatureFlow::CurvatureFlow(FlowMesh& mesh, const DiffusionOptions& options)
    : mesh_(mesh),
      options_(options),
      unknowns_(mesh.fixed),
      diffusion_("diffusion of mean curvature"),
      refit_("refit to mean curvature"),
      time_step_(options.time_step) {
  moved_ = Eigen::VectorXd::Zero(mesh.positions.rows());
}

Eigen::VectorXd CurvatureFlow::round() {
  Points& X = mesh_.positions;
  const Index n = X.rows();
  moved_.setZero();
  if (unknowns_.n_free() == 0) return moved_;
  const SparseMatrix K = cotangent_stiffness(X, mesh_.triangles);
  const Eigen::VectorXd M = bounded_mass(lumped_mass(X, mesh_.triangles));
  const Points N = vertex_normals(X, mesh_.triangles);
  const Points curvature = K * X;
  Eigen::VectorXd H(n);
  for (Index v = 0; v < n; ++v) H(v) = N.row(v).dot(curvature.row(v)) / (2 * M(v));
  const Eigen::VectorXd measured = H;
  diffuse(K, M, H);

  // STEP 2: L X = 2 H N in least squares, L = M⁻¹ K, integrated (times M, in units of the mean area), rows
  // weighted by how smooth the vertex is. Solved for the step, so that what is held needs no columns.
  // Of what L X lacks only the part along N counts, and so of the step: the rest is the error of L on uneven
  // quads, and following it would let the vertices drift along the surface without end.
  Eigen::VectorXd d(n);
  const double mean_area = M.mean();
  for (Index v = 0; v < n; ++v) {
    const auto i = static_cast<size_t>(v);
    const double row = mesh_.without_row[i] ? 0 : similarity(mesh_.sharpness[i], 0);
    d(v) = row * row * mean_area / M(v);
  }
  Points lack(n, 3);
  for (Index v = 0; v < n; ++v) lack.row(v) = 2 * d(v) * M(v) * (H(v) - measured(v)) * N.row(v);
  const Points right = K.transpose() * lack;
  const std::vector<int> none(static_cast<size_t>(n), -1);
  SparseMatrix A = squared_stiffness(K, d, unknowns_.free_index(), none).lower;
  Eigen::MatrixXd b = unknowns_.free_rows(right);
  const double anchor = kAnchor * A.diagonal().mean();
  for (Index u = 0; u < unknowns_.n_free(); ++u) {
    const int v = unknowns_.free()[static_cast<size_t>(u)];
    const bool soft = mesh_.soft[static_cast<size_t>(v)];
    if (soft) b.row(u) += options_.fidelity * (mesh_.targets.row(v) - X.row(v));
    A.coeffRef(u, u) += anchor + (soft ? options_.fidelity : 0);
  }
  refit_.factorize(A);
  Points step = Points::Zero(n, 3);
  unknowns_.set_free_rows(refit_.solve(b), step);
  for (const int v : unknowns_.free())
    if (!mesh_.soft[static_cast<size_t>(v)]) step.row(v) = step.row(v).dot(N.row(v)) * N.row(v).eval();
  move(step);
  return moved_;
}

/// Moves the vertices; where triangles would fold, only part of the way.
void CurvatureFlow::move(const Points& step) {
  Points& X = mesh_.positions;
  const Triangles& triangles = mesh_.triangles;
  Eigen::VectorXd share = Eigen::VectorXd::Ones(X.rows());
  std::vector<char> shorten(static_cast<size_t>(X.rows()));
  for (int k = 0; k < 12; ++k) {
    std::fill(shorten.begin(), shorten.end(), 0);
    int n_bad = 0;
    for (Index f = 0; f < triangles.rows(); ++f) {
      Vector3d old[3], now[3];
      for (int c = 0; c < 3; ++c) {
        const int v = triangles(f, c);
        old[c] = X.row(v);
        now[c] = X.row(v) + share(v) * step.row(v);
      }
      const Vector3d before = (old[1] - old[0]).cross(old[2] - old[0]),
                     after = (now[1] - now[0]).cross(now[2] - now[0]);
      const double dot = before.dot(after);
      if (dot >= kLeastTurn * before.norm() * after.norm() && dot >= kLeastShrink * before.squaredNorm())
        continue;
      ++n_bad;
      for (int c = 0; c < 3; ++c) shorten[static_cast<size_t>(triangles(f, c))] = 1;
    }
    if (n_bad == 0) break;
    for (Index v = 0; v < X.rows(); ++v)
      if (shorten[static_cast<size_t>(v)]) share(v) *= 0.5;
  }
  for (Index v = 0; v < X.rows(); ++v) {
    moved_(v) = share(v) * step.row(v).norm();
    X.row(v) += share(v) * step.row(v);
  }
}

double CurvatureFlow::similarity(double s, double t) const {  // (6.5): D is not squared, σ is
  return std::exp(-std::abs(s - t) / (options_.similarity * options_.similarity));
}

/// STEP 1: (M + τ K_w) H⁺ = M H with the weights (6.5) on the edges, and τ times the area of a vertex at the
/// thesis's three splits in each face of the model: curvature then spreads over the same share of a face
/// however finely it is split, and whatever the size of the others.
void CurvatureFlow::diffuse(const SparseMatrix& K, const Eigen::VectorXd& M, Eigen::VectorXd& H) {
  const Index n = M.size();
  Eigen::VectorXd area = Eigen::VectorXd::Zero(static_cast<Index>(mesh_.patches.size())), count = area;
  const Points& X = mesh_.positions;
  for (Index f = 0; f < mesh_.triangles.rows(); ++f) {
    const auto p = [&](int k) -> Vector3d { return X.row(mesh_.triangles(f, k)); };
    area(mesh_.patch[static_cast<size_t>(f)]) += (p(1) - p(0)).cross(p(2) - p(0)).norm() / 2;
    count(mesh_.patch[static_cast<size_t>(f)]) += 0.5;
  }
  const double finer = std::pow(4.0, options_.splits - 3);
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(n), met = tau;
  for (Index f = 0; f < mesh_.triangles.rows(); ++f) {
    const int patch = mesh_.patch[static_cast<size_t>(f)];
    for (int k = 0; k < 3; ++k) {
      tau(mesh_.triangles(f, k)) += time_step_ * finer * area(patch) / count(patch);
      met(mesh_.triangles(f, k)) += 1;
    }
  }
  tau.array() /= met.array().max(1);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(2 * K.nonZeros()));
  for (Index j = 0; j < K.outerSize(); ++j)
    for (SparseMatrix::InnerIterator entry(K, j); entry; ++entry) {
      const Index i = entry.row();
      if (i >= j) continue;
      // Obtuse triangles have edges of the other sign: curvature would flow uphill there, and the matrix
      // need not be positive.
      double weight =
          (tau(i) + tau(j)) / 2 * std::min(0.0, entry.value()) *
          similarity(mesh_.sharpness[static_cast<size_t>(i)], mesh_.sharpness[static_cast<size_t>(j)]);
      // Where curvature is not known, none flows.
      if (mesh_.without_row[static_cast<size_t>(i)] || mesh_.without_row[static_cast<size_t>(j)]) weight = 0;
      entries.emplace_back(j, i, weight);
      entries.emplace_back(i, i, -weight);
      entries.emplace_back(j, j, -weight);
    }
  for (Index v = 0; v < n; ++v) entries.emplace_back(v, v, M(v));
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  diffusion_.factorize(A);
  for (int k = 0; k < options_.diffusion_steps; ++k) H = diffusion_.solve(M.cwiseProduct(H));
}

}  // namespace batten::detail
