#pragma once
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten::fairing_detail {

/// 1 at border vertices, for keep_boundary; all 0 otherwise. Checks the mesh on the way.
/// @throws InvalidInput on an index out of range, a coordinate that is not finite, or a mesh that is not
/// manifold and consistently oriented.
std::vector<char> fixed_vertices(const Points& positions, const Triangles& triangles, bool keep_boundary);

/// Solves A X = B (A symmetric positive definite, both halves stored) for the rows that are not fixed; the
/// fixed rows of X keep the values they have. @param X the values on entry, the solution on return.
/// @throws Cancelled, with X as it was.
void solve_with_fixed(SparseCholesky& solver, const SparseMatrix& A, const Eigen::MatrixXd& B,
                      const std::vector<char>& fixed, Points& X, const Progress& progress = {});

/// Lumped mass with a floor, so that vertices without area do not divide by zero.
Eigen::VectorXd bounded_mass(const Points& positions, const Triangles& triangles);

/// Cotangent stiffness of noisy meshes: cotangents within ± 20 (angles down to 3°).
SparseMatrix bounded_stiffness(const Points& positions, const Triangles& triangles);

/// K with every off-diagonal weight times exp(−|H_i − H_j|²/σ) (2.27, 2.30), rows summing to zero; negative
/// weights become 0. @param H n × c. Defined beside surface_diffusion().
SparseMatrix similar_stiffness(const SparseMatrix& K, const Eigen::MatrixXd& H, double similarity);

}  // namespace batten::fairing_detail
