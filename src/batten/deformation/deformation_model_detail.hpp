#pragma once
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/deformation/deformer.hpp"
#include "batten/deformation/dual_laplacian.hpp"
#include "batten/operators/laplacian.hpp"

// Private to the room.
namespace batten::detail {

/// The energies of a deformation: the matrix of what is minimised, and the forces of the rest shape in it.
class DeformationModel {
 public:
  /// @param rest positions, n × 3; must outlive this. @param diameter of the mesh.
  DeformationModel(const Points& rest, const Triangles& triangles, const DeformOptions& options,
                   double diameter);

  // The matrix is c K M⁻¹ K + T.
  const SparseMatrix& stiffness() const { return K_; }                   ///< K, n × n
  const Eigen::VectorXd& inverse_mass() const { return inverse_mass_; }  ///< diagonal of M⁻¹, n
  double bending() const { return bending_ + followed_detail_; }         ///< c
  SparseMatrix second_order() const;                                     ///< T, n × n, maybe empty

  /// The stiffness matrix of ∇·(G ∇·) in (2.60), G = H² − K inside and 0 on borders.
  /// @throws InvalidInput when the triangles are no oriented manifold.
  SparseMatrix curvature_stiffness(const Triangles& triangles) const;
  /// Makes T of TotalCurvature: −2 c of what curvature_stiffness() gave.
  void set_curvature_term(double c, const SparseMatrix& curvature);

  /// GaussNewton: makes ready for detail_forces(). @param used per vertex whether it has triangles.
  /// @throws InvalidInput when the triangles are no oriented manifold.
  void follow_normals(const Triangles& triangles, const std::vector<char>& used);

  /// The differentials of the rest shape in the displacement energy, (c K M⁻¹ K + T) X without detail.
  Points displacement_forces() const;
  /// Right-hand side of the alternating method: the differentials of the rest shape, turned.
  /// @param rotations one per vertex.
  Points turned_rest(const std::vector<Eigen::Matrix3d>& rotations) const;
  /// The detail part of the right-hand side of (2.79): λ_2 K M⁻¹ δ̂, and the membrane's.
  /// @param rotations those of the last call, empty at first; where to begin to fit.
  Points detail_forces(const Points& deformed, std::vector<Eigen::Matrix3d>& rotations) const;

 private:
  void set_second_order(const DeformOptions& options, double diameter);
  Points apply_bending(const Points& vectors) const;
  /// T X with every edge of the rest shape turned by the mean of the rotations at its ends.
  Points turned_edges(const SparseMatrix& T, const std::vector<Eigen::Matrix3d>& rotations) const;

  const Points& rest_;
  SparseMatrix K_;
  Eigen::VectorXd inverse_mass_;
  Points rest_vectors_;         ///< K X: integrated Laplacian coordinates
  double bending_ = 0;          ///< factor of K M⁻¹ K in the displacement energy
  double detail_weight_;        ///< λ_2
  double followed_detail_ = 0;  ///< λ_2 where it adds to the matrix: GaussNewton
  SparseMatrix second_order_;   ///< of the displacement energy: K / ℓ², −2 c K_G or K; maybe empty
  SparseMatrix membrane_;  ///< GaussNewton: λ_2 K / ℓ², whose edges turn with the one-rings; maybe empty
  std::unique_ptr<DualLaplacian> dual_;
  std::vector<int> not_followed_;  ///< vertices whose vectors turn with a rotation of their ring
};

}  // namespace batten::detail
