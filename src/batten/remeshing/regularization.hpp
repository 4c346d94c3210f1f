#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/linalg/iterative.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten {

// STEP 1 and STEP 2 of adaptive remeshing (H 2.2.1, 2.2.2) on plain arrays, and the Laplacian flow (H 2.46).

/// The cotangent stiffness with negative weights taken as zero, so that every row is a mean.
SparseMatrix clamped_stiffness(const Triangles& triangles, const EdgeLengths& lengths,
                               Eigen::Index n_vertices);

/// The areas of STEP 1.
struct RegularizedAreas {
  Eigen::VectorXd areas;
  IterativeReport
      solve;  ///< `converged` is false where it stopped early, or failed and left the areas as they were
};

/// STEP 1: the wanted vertex areas, one implicit step of ∂A/∂t = Δ_w A (2.38), with weights w_ij exp(−(H_i −
/// H_j)²/σ) that stop at changes of curvature (2.39, 2.30; without the printed normalisation, which is not
/// symmetric and loses area). τ = 10 Ā / max |L_w A|. Scaled to the sum of `areas`.
/// @param stiffness as clamped_stiffness(). @param curvature |H| per vertex; scaled to maximum 1 inside.
/// @param shares relative area per vertex that the surface asks for (sizes squared); the diffused quantity is
/// area over share. All ones is H's form.
RegularizedAreas regularized_areas(const SparseMatrix& stiffness, const Eigen::VectorXd& areas,
                                   const Eigen::VectorXd& curvature, const Eigen::VectorXd& shares,
                                   double sigma = 0.05, const Progress& progress = {});

/// How relocation_matrix() weighs neighbours.
struct RelocationWeights {
  double area = 0.5;  ///< λ_1 of (2.44): the pull of neighbours with too much area
  double edge = 0.5;  ///< λ_2: the pull of neighbours far away
  /// σ of the sigmoid (2.43). H takes 0.1, which all but switches neighbours on and off: valence six on 63 %
  /// of fandisk's vertices against 80 % with 1, and 46° as the mean smallest angle against 53°.
  double sigma = 1.0;
  /// w_ij of (1.18) as H has them, instead of 1 per edge. Cotangent weights leave every vertex of a flat
  /// one-ring where it is, so that only the sigmoid moves it.
  bool cotangent = false;
  /// α of g = 1 / (1 + (|H|/α)²) (2.41), H scaled to maximum 1: vertices more curved than this hardly move.
  /// 0 leaves g out.
  double curvature = 0;
};

/// STEP 2: the matrix g L_{w_A} (2.43, 2.44): rows are differences to weighted means of neighbours.
/// @param wanted areas of STEP 1. @param lengths wanted edge length per vertex.
SparseMatrix relocation_matrix(const SparseMatrix& stiffness, const Points& positions,
                               const Eigen::VectorXd& areas, const Eigen::VectorXd& wanted,
                               const Eigen::VectorXd& lengths, const Eigen::VectorXd& curvature,
                               const RelocationWeights& weights = {});

/// The matrix of the Laplacian flow (2.47): means of the neighbours weighted with their areas (over shares).
SparseMatrix laplacian_flow_matrix(const SparseMatrix& stiffness, const Eigen::VectorXd& areas,
                                   const Eigen::VectorXd& shares);

/// X + τ (I − N Nᵀ) L X (2.45), `steps` times with τ = `share` as long as that moves a vertex by at most 0.1
/// wanted lengths (2.48, per vertex: one bad vertex does not hold up the rest). Vertices with `fixed` stay.
Points relocated(const SparseMatrix& L, const Points& positions, const Points& normals,
                 const Eigen::VectorXd& lengths, const std::vector<char>& fixed, int steps,
                 double share = 1.0, double most = 0.1);

}  // namespace batten
