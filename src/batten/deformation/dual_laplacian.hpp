#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Laplacian coordinates written in the face normals around each vertex (the dual Laplacian of
/// [au2006] and [huang2006]; H 2.74–2.77), so that they turn with the surface: δ_i = Σ_f μ_if (x_j − x_i) ×
/// (x_k − x_i) over the triangles f = (i, j, k) at vertex i.
class DualLaplacian {
 public:
  /// Finds μ (H 2.74): of the many solutions, the one of least norm. Directions in which the normals of a
  /// ring hardly spread are left out, because their μ would blow up small changes of the normals.
  /// @param delta n × 3, the vectors to follow the surface (here integrated, M times Laplacian coordinates).
  DualLaplacian(const Points& positions, const Triangles& triangles, const Points& delta);

  /// Vectors of the deformed shape: direction Σ_f μ_if n_f, length as before (H 2.76, 2.77). Zero at vertices
  /// whose vectors the normals could not express: see `followed()`.
  void evaluate(const Points& positions, Points& delta) const;

  /// Per vertex: 1 where the normals express the vector to within 15 % of its length. Others (flat rings
  /// on a border, whose vectors lie in the surface) need a rotation of their own.
  const std::vector<char>& followed() const { return followed_; }

 private:
  Triangles triangles_;
  Points mu_;               ///< m × 3, per corner
  Eigen::VectorXd length_;  ///< of the rest vectors
  std::vector<char> followed_;
};

}  // namespace batten
