#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten {

// Sign and scale (docs/methods.md#conventions): stiffness matrices K are symmetric positive semi-definite
// with rows that sum to zero, mass is lumped, and the Laplacian is Δ = −M⁻¹K, so that M⁻¹K x = 2 H N on a
// closed surface.

/// How far cotangents may go.
struct CotangentOptions {
  /// Cotangents are held within ± this bound, so that needles keep finite weights; 1e3 is an angle of 0.06°.
  double bound = 1e3;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Cotangent stiffness, n × n, integrated (not divided by areas): K_ij = −(cot α + cot β)/2. S (2.36), H
/// (1.18). @throws InvalidInput when an option is out of range.
SparseMatrix cotangent_stiffness(const Triangles& triangles, const EdgeLengths& lengths,
                                 Eigen::Index n_vertices, const CotangentOptions& options = {});
SparseMatrix cotangent_stiffness(const Points& positions, const Triangles& triangles);

/// Uniform (umbrella) stiffness: the graph Laplacian, degree on the diagonal, −1 per edge. No unit.
SparseMatrix uniform_stiffness(const Triangles& triangles, Eigen::Index n_vertices);

/// Lumped mass: areas around vertices that sum to the area of the mesh.
enum class MassKind {
  MixedVoronoi,  ///< [meyer2003], S algorithm 2.11 with the test "triangle is non-obtuse"
  Barycentric,   ///< a third of each triangle (H)
};
/// n areas, 0 at vertices without triangles.
Eigen::VectorXd lumped_mass(const Triangles& triangles, const EdgeLengths& lengths, Eigen::Index n_vertices,
                            MassKind kind = MassKind::MixedVoronoi);
Eigen::VectorXd lumped_mass(const Points& positions, const Triangles& triangles,
                            MassKind kind = MassKind::MixedVoronoi);

/// The lower triangle of K diag(d) K for the rows and columns `unknowns` (ascending vertex numbers), and the
/// columns `knowns` of the same rows. Filled directly over the two-ring, in time linear in its size, several
/// times faster than the product of three sparse matrices.
struct SquaredStiffness {
  SparseMatrix lower;  ///< u × u, lower triangle: what SparseCholesky reads
  SparseMatrix known;  ///< u × k: moves known values to the right-hand side
};
/// @param index_of_unknown per vertex its row, or −1; @param index_of_known likewise.
SquaredStiffness squared_stiffness(const SparseMatrix& K, const Eigen::VectorXd& d,
                                   const std::vector<int>& index_of_unknown,
                                   const std::vector<int>& index_of_known);

}  // namespace batten
