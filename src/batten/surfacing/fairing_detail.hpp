#pragma once
#include <memory>
#include <vector>

#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::detail {

/// The linear systems of one mesh and one metric: assembled and factored in set_metric(), then solved for any
/// number of right-hand sides. All lengths are in diameters.
///
/// With K the stiffness, M the mass and R the rows kept (all but those of border vertices, where neither the
/// Laplacian nor the curvature of (4.18) means anything), every solve of order two has the matrix K R M⁻¹ K:
/// base positions and normals (4.12), final positions (4.22) and the re-solves share one factor.
class FairingSystems {
 public:
  /// @param fixed per vertex: on the network. @param border per vertex: on the border of an open surface.
  /// @param soft_weights per vertex: weight of its soft constraint, or empty for hard constraints.
  FairingSystems(std::vector<char> fixed, std::vector<char> border, Eigen::VectorXd soft_weights);

  /// Assembles for the triangles with these edge lengths and drops the factors of earlier metrics.
  void set_metric(const Triangles& triangles, const EdgeLengths& lengths);

  const SparseMatrix& stiffness() const { return K_; }
  /// R M⁻¹: one over the area of a vertex, 0 on borders.
  const Eigen::VectorXd& inverse_mass() const { return inverse_mass_; }

  /// The values (n × k) that are `values` on the network and least Σ A |Δ^(order/2)|² elsewhere.
  Eigen::MatrixXd polyharmonic(int order, const Eigen::MatrixXd& values);

  /// min Σ (1/A_v) |(K X)_v − target_v|² over all rows kept, with X given on the network: (4.20–4.26) with
  /// areas. @param target n × 3, integrated (2 H N times area).
  Eigen::MatrixXd fit_laplacian(const Eigen::MatrixXd& target, const Eigen::MatrixXd& values);

  /// (4.27): harmonic 2HN with the given vectors on the network, then the positions that have it.
  Eigen::MatrixXd biharmonic_with_curvature(const Eigen::MatrixXd& curvature_vectors,
                                            const Eigen::MatrixXd& values);

 private:
  struct System {
    SparseCholesky factor;
    SparseMatrix known;
    bool ready = false;
    explicit System(const char* name) : factor(name) {}
  };
  void prepare(int order);
  System& system(int order) { return *systems_[order - 1]; }
  Eigen::MatrixXd solve(int order, const Eigen::MatrixXd& right_side, const Eigen::MatrixXd& values);

  std::vector<char> fixed_, border_;
  Eigen::VectorXd soft_weights_;
  std::vector<int> unknown_, known_, vertex_of_unknown_, vertex_of_known_;
  SparseMatrix K_;
  Eigen::VectorXd mass_, inverse_mass_;
  std::unique_ptr<System> systems_[3];
};

/// Unit normals from propagated ones; those that vanish take the mean of the smallest ring of neighbours
/// whose mean does not (S 4.5.1). Rows on the network become `given`.
void normalize_propagated(Points& normals, const SparseMatrix& adjacency);

/// Integrated mean curvature 2 H A of each vertex from positions and normals along its edges:
/// ½ Σ_j w_ij (N_j − N_i)·(x_j − x_i) with the cotangent weights w. On a mesh inscribed in a sphere it equals
/// ⟨K x, N⟩ exactly, where (4.18) has an error of some 10 % per vertex from triangles that are not
/// equilateral.
Eigen::VectorXd curvature_along_edges(const SparseMatrix& K, const Points& positions, const Points& normals);

/// The triangle looks away from the sum of the normals N of its corners.
bool is_folded(const Points& X, const Points& N, const Triangles& triangles, Eigen::Index triangle);

}  // namespace batten::detail
