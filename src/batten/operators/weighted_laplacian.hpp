#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {

/// Weights s_ij of an edge in L = D S, S_ij = s_ij and rows of S summing to zero. H (1.16–1.22)
enum class LaplacianWeights {
  /// s = cot α + cot β, D = 1/(2 A) with mixed Voronoi areas A: the Laplacian, in 1/length². (1.18)
  Cotangent,
  /// s = 1, D = 1/valence: the offset of the neighbours' mean, in no unit. (1.20)
  Umbrella,
  /// s = 1/length, D = 2 / Σ lengths: the umbrella for edges of unequal length, in 1/length². On even meshes
  /// it is Δ/2. (1.21)
  ScaledUmbrella,
  /// s = (tan γ/2 + tan η/2)/length with the angles γ, η at vertex i beside the edge, D = 1/Σ s: never
  /// negative, and zero on linear functions in a plane. Rows normalised, as (1.16) asks and (1.22) with D = I
  /// does not; S is not symmetric. (1.22)
  MeanValue,
};

/// The discrete Laplacian L = D S, n × n, with the sign of Δ (a peak goes down) and rows that sum to zero.
/// Rows of vertices without triangles are zero.
/// @throws InvalidInput on an index out of range, and where the mesh is not manifold and oriented.
SparseMatrix weighted_laplacian(const Points& positions, const Triangles& triangles,
                                LaplacianWeights weights);

/// L^power, the discretisation of Δ^power. H (1.23)
/// @throws InvalidInput unless L is square and `power` at least 0 (0 is the identity).
SparseMatrix laplacian_power(const SparseMatrix& L, int power);

}  // namespace batten
