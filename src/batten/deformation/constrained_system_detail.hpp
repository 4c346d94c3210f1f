#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/operators/laplacian.hpp"

// Private to the room.
namespace batten::detail {

/// The linear system of a deformation for the vertices that are free to move, factorised once.
class ConstrainedSystem {
 public:
  /// @param constrained vertices that are given values: held, or with a soft weight pulled.
  /// @param n vertices of the mesh.
  /// @param soft_weight as DeformOptions::soft_weight.
  /// @throws InvalidInput on a vertex out of range or named twice.
  ConstrainedSystem(std::vector<int> constrained, Eigen::Index n, double soft_weight);

  const std::vector<int>& constrained() const { return constrained_; }
  /// Per vertex its row among the constrained ones, or −1.
  const std::vector<int>& constraint_of() const { return index_of_known_; }

  /// A vertex without triangles is nothing to the energy: it stays unless it is constrained.
  /// @param used per vertex whether it has triangles.
  void choose_unknowns(const std::vector<char>& used);

  /// Factorises c K M⁻¹ K + T (+ soft weights) for the unknowns. May be called again with another T.
  /// @param inverse_mass n, the diagonal of M⁻¹. @param bending c, at least 0.
  /// @param T n × n, full, maybe empty.
  /// @throws SolverFailure when the matrix is not positive definite; Cancelled.
  void factorize(const SparseMatrix& K, const Eigen::VectorXd& inverse_mass, double bending,
                 const SparseMatrix& T, const Progress& progress);

  /// Solves A X = B + (what the constraints add) and fills in the constrained rows.
  /// @param B n × k. @param values c × k: targets, or target displacements.
  /// @param outside n × k: what vertices without triangles get.
  template <typename Rows>
  Rows solve(const Rows& B, const Rows& values, const Rows& outside) const {
    Eigen::MatrixXd right(unknowns_.size(), B.cols());
    for (std::size_t u = 0; u < unknowns_.size(); ++u) right.row(u) = B.row(unknowns_[u]);
    if (is_soft())
      for (std::size_t c = 0; c < constrained_.size(); ++c)
        right.row(soft_unknowns_[c]) += pull_ * values.row(static_cast<Eigen::Index>(c));
    else
      right -= known_ * values;
    const Eigen::MatrixXd solution = cholesky_.solve(right);
    Rows X = outside;
    for (std::size_t u = 0; u < unknowns_.size(); ++u) X.row(unknowns_[u]) = solution.row(u);
    if (!is_soft())
      for (std::size_t c = 0; c < constrained_.size(); ++c)
        X.row(constrained_[c]) = values.row(static_cast<Eigen::Index>(c));
    return X;
  }

 private:
  bool is_soft() const { return soft_weight_ > 0; }
  void add_soft_weights(SparseMatrix& lower);

  std::vector<int> constrained_;
  std::vector<int> index_of_known_, index_of_unknown_;  ///< per vertex, or −1
  double soft_weight_;
  std::vector<int> unknowns_;       ///< vertices to solve for; constrained ones too where they are soft
  std::vector<int> soft_unknowns_;  ///< soft constraints: the unknown of each constrained vertex
  SparseMatrix known_;              ///< u × c: moves hard targets to the right-hand side
  // Dragging lives on back-substitutions, and CHOLMOD's take all three coordinates in one pass over the
  // factor.
  SparseCholesky cholesky_{"deformation", CholeskyBackend::Cholmod};
  double pull_ = 0;  ///< the soft weight as an entry of the matrix
};

}  // namespace batten::detail
