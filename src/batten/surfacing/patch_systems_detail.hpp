#pragma once
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/core/index.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten::detail {

/// The harmonic and the biharmonic system of a mesh whose curves are held, with one small factor per patch.
/// A patch is a connected set of free vertices; held vertices lie between them.
///
/// The stiffness K of the free vertices f is block diagonal over the patches, so harmonic solves fall apart.
/// The biharmonic matrix K M⁻¹ K does not: rows at held vertices c, which make the surface smooth across its
/// curves, join all patches around them. With r the residuals of the rows at free vertices,
///
///     x_f = K_ff⁻¹ (t_f − K_fc x_c + r),   row at c: q + Zᵀ r,   Z = K_ff⁻¹ K_fc,
///     q = K_cf K_ff⁻¹ (t_f − K_fc x_c) + K_cc x_c − t_c,
///
/// and the least Σ r²/M over all rows has r = −M_f Z λ with (M_c + Zᵀ M_f Z) λ = q: what is left to couple is
/// a mass matrix on the curves, one dense block per patch, and a solve is three harmonic ones per patch. Held
/// vertices on the border have no row (S 4.5.2) and no λ. All of it is better conditioned than K M⁻¹ K.
class PatchSystems {
 public:
  /// @param stiffness n × n; only its pattern is looked at. @param unknowns the held vertices.
  PatchSystems(const SparseMatrix& stiffness, HeldUnknowns unknowns);

  /// Takes a metric: new values of the same pattern. @param stiffness K, n × n. @param mass areas of the
  /// vertices, all positive. @param row_weights R M⁻¹, 0 where a held vertex has no row.
  /// @throws SolverFailure when the stiffness of a patch is not positive definite.
  void factorize(const SparseMatrix& stiffness, const Eigen::VectorXd& mass,
                 const Eigen::VectorXd& row_weights);

  /// K x = right at the free vertices. @param right n × k. @param values n × k, read at held vertices.
  /// @return n × k, equal to `values` there.
  Eigen::MatrixXd harmonic(const Eigen::MatrixXd& right, const Eigen::MatrixXd& values) const;
  /// min Σ R M⁻¹ (K x − target)² with x = values at the held vertices; sizes as above. The first call of a
  /// metric sets up the coupling on the curves. @throws SolverFailure.
  Eigen::MatrixXd biharmonic(const Eigen::MatrixXd& target, const Eigen::MatrixXd& values);

  /// min Σ R M⁻¹ (K d − target)² over displacements d of the vertices of some patches, d = 0 in all others;
  /// over the rows of their vertices and rims. Costs what those patches cost; the coupling of the last set of
  /// patches is kept.
  /// @param patches increasing. @param target n × k, or nothing for 0. @param displacements n × k, read at
  /// held vertices, which may move only where all patches around them are listed; written at the vertices of
  /// the patches. @throws SolverFailure.
  void displace(const std::vector<int>& patches, const Eigen::MatrixXd* target,
                Eigen::MatrixXd& displacements);

  int n_patches() const { return static_cast<int>(patches_.size()); }
  /// The vertices of a patch, increasing.
  const std::vector<int>& vertices(int patch) const { return patches_[at(patch)].vertices; }
  /// The held vertices with a neighbour in a patch, increasing.
  const std::vector<int>& rim(int patch) const { return patches_[at(patch)].rim; }

  /// Multiplications to set up the biharmonic system, estimated from the sizes of patches and rims.
  double cost() const;

 private:
  struct Patch {
    std::vector<int> vertices, rim;
    SparseCholesky factor{"the harmonic system of a patch"};
    SparseMatrix to_rim;       ///< K_fc: vertices × rim
    Eigen::VectorXd mass;      ///< M_f of its vertices
    Eigen::MatrixXd rim_mass;  ///< Zᵀ M_f Z: rim × rim; empty until it is asked for
  };
  /// M_c + Zᵀ M_f Z over a set of patches.
  struct Coupling {
    std::vector<int> patches;
    std::vector<int> row_of_vertex;  ///< −1: none
    std::vector<int> vertex_of_row;
    SparseCholesky factor{"the curves of the biharmonic system"};
    bool ready = false;
  };

  void find_patches(const SparseMatrix& stiffness);
  void fill_rim_mass(Patch& patch) const;
  void prepare(Coupling& coupling);
  /// @param target n × k, or nothing for 0. @param X n × k: held values on entry, free ones on return.
  void solve(const Coupling& coupling, const Eigen::MatrixXd* target, Eigen::MatrixXd& X) const;

  HeldUnknowns unknowns_;
  std::vector<Patch> patches_;
  SparseMatrix held_stiffness_;  ///< K_cc
  Eigen::VectorXd row_weights_;
  Coupling all_, some_;
};

}  // namespace batten::detail
