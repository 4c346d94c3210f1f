#pragma once
#include <memory>
#include <vector>

#include "batten/linalg/held_unknowns.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/surfacing/patch_systems_detail.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::detail {

/// Which factors the systems of a mesh take.
enum class FairingFactors {
  Auto,   ///< patches where their curves are held and they are many enough that it takes less work
  Whole,  ///< one factor over all patches
  Patches,
};

/// The linear systems of one mesh and one metric: assembled and factored when first asked for, then solved
/// for any number of right-hand sides. All lengths are in diameters.
///
/// With K the stiffness, M the mass and R the rows kept (all but those of border vertices, where neither the
/// Laplacian nor the curvature of (4.18) means anything), every solve of order two has the matrix K R M⁻¹ K:
/// base positions and normals (4.12), final positions (4.22) and the re-solves share one factor.
class FairingSystems {
 public:
  /// @param fixed per vertex: on the network. @param border per vertex: on the border of an open surface.
  /// @param soft_weights per vertex: weight of its soft constraint, or empty for hard constraints.
  FairingSystems(const std::vector<char>& fixed, std::vector<char> border, Eigen::VectorXd soft_weights,
                 FairingFactors factors = FairingFactors::Auto);

  /// Assembles for the triangles with these edge lengths and drops the factors of earlier metrics. The
  /// triangles of the first call stay.
  void set_metric(const Triangles& triangles, const EdgeLengths& lengths);

  const SparseMatrix& stiffness() const { return K_; }
  /// R M⁻¹: one over the area of a vertex, 0 on borders.
  const Eigen::VectorXd& inverse_mass() const { return inverse_mass_; }

  /// The values (n × k) that are `values` on the network and least Σ A |Δ^(order/2)|² elsewhere.
  Eigen::MatrixXd polyharmonic(int order, const Eigen::MatrixXd& values);

  /// min Σ (1/A_v) |(K X)_v − target_v|² over all rows kept, with X given on the network: (4.20–4.26) with
  /// areas. @param target n × 3, integrated (2 H N times area).
  Eigen::MatrixXd fit_laplacian(const Eigen::MatrixXd& target, const Eigen::MatrixXd& values);

  /// min Σ ½ w_ij |r_i − r_j|² + ε Σ A_v |r_v|² with r = M⁻¹ (K X − target), over rows kept and the edges
  /// between them, with X given on the network: the least ∫|∇r|² where fit_laplacian() has the least ∫|r|².
  /// The second term decides what the first leaves open, as at a single row between borders. One factor of
  /// sixth order over all patches: two to three times the work of one of fourth. @pre hard constraints.
  /// @param target n × 3, integrated.
  Eigen::MatrixXd fit_laplacian_gradient(const Eigen::MatrixXd& target, const Eigen::MatrixXd& values);

  /// (4.27): harmonic 2HN with the given vectors on the network, then the positions that have it.
  Eigen::MatrixXd biharmonic_with_curvature(const Eigen::MatrixXd& curvature_vectors,
                                            const Eigen::MatrixXd& values);

  /// The factors per patch of the present metric, or nothing where the whole is factorised at once.
  PatchSystems* patches();

 private:
  void prepare(int order);
  Eigen::MatrixXd solve(int order, Eigen::MatrixXd right_side, const Eigen::MatrixXd& values);

  HeldUnknowns unknowns_;
  std::vector<char> border_;
  Eigen::VectorXd soft_weights_;
  FairingFactors factors_;
  SparseMatrix K_;
  Eigen::VectorXd mass_, inverse_mass_;
  std::unique_ptr<HeldSolver> systems_[3];  ///< by order − 1
  bool ready_[3] = {};
  std::unique_ptr<HeldSolver> gradient_system_;
  SparseMatrix gradient_rows_;  ///< K M⁻¹ S M⁻¹, S the stiffness of the edges between rows kept
  bool gradient_ready_ = false;
  std::unique_ptr<PatchSystems> patches_;
  bool patches_ready_ = false;
};

/// Unit normals from propagated ones at the given vertices; those that vanish take the mean of the smallest
/// ring of neighbours whose mean does not (S 4.5.1).
void normalize_propagated(Points& normals, const SparseMatrix& adjacency, const std::vector<int>& vertices);
/// The same for all vertices.
void normalize_propagated(Points& normals, const SparseMatrix& adjacency);

/// Integrated mean curvature 2 H A of each vertex from positions and normals along its edges:
/// ½ Σ_j w_ij (N_j − N_i)·(x_j − x_i) with the cotangent weights w. On a mesh inscribed in a sphere it equals
/// ⟨K x, N⟩ exactly, where (4.18) has an error of some 10 % per vertex from triangles that are not
/// equilateral.
Eigen::VectorXd curvature_along_edges(const SparseMatrix& K, const Points& positions, const Points& normals);
/// The same at one vertex.
double curvature_along_edges(const SparseMatrix& K, const Points& positions, const Points& normals,
                             Eigen::Index vertex);

/// Curvature target 2HN·A of the final fit, n × 3. The first metric comes from plane layouts that do not fit
/// together, so there the positions' own curvature vector (4.18) is used; later ones are those of the
/// positions themselves, and the form along edges is exact on spheres.
Points curvature_target(const FairingSystems& systems, const Triangles& triangles, bool metric_from_layout,
                        const Points& positions, const Points& normals);
/// The same at some vertices, written to their rows of `target`. @param around the triangles that have one of
/// them for a corner, and maybe others.
void curvature_target(const FairingSystems& systems, const Triangles& around, bool metric_from_layout,
                      const Points& positions, const Points& normals, const std::vector<int>& vertices,
                      Points& target);

/// The triangle looks away from the sum of the normals N of its corners.
bool is_folded(const Points& X, const Points& N, const Triangles& triangles, Eigen::Index triangle);
/// All of them, ascending.
std::vector<int> all_folded(const Points& X, const Points& N, const Triangles& triangles);

/// The part of its area that is folded, per patch.
std::vector<double> folded_shares(const Points& X, const Points& N, const Triangles& triangles,
                                  const std::vector<int>& patch_of_triangle, std::size_t n_patches);
/// A patch counts as folded above this share: less are slivers beside samples that lie close together, which
/// no other layout would mend.
constexpr double kFoldedShare = 1e-3;

/// How many triangles are folded, and how many have an angle below half a degree.
struct Soundness {
  int folded = 0, degenerate = 0;
};
Soundness soundness_of(const Points& X, const Points& N, const Triangles& triangles);
Soundness soundness_of(const Points& X, const Points& N, const Triangles& triangles,
                       const std::vector<int>& chosen);

}  // namespace batten::detail
