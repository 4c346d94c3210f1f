#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// What a deformation minimises, as a quadratic energy of the displacement d = X' − X. With the cotangent
/// stiffness K and the lumped mass M (docs/methods.md#conventions):
enum class DeformationEnergy {
  Stretch,         ///< −Δd = 0: K. C⁰ at the handles. H (2.57)
  Bend,            ///< Δ²d = 0: K M⁻¹ K. C¹ at the handles. H (2.58)
  Combined,        ///< −k_s Δd + k_b Δ²d = 0: K / ℓ² + K M⁻¹ K. H (2.59)
  TotalCurvature,  ///< Δ²d + 2 ∇·(G ∇d) = 0, G = H² − K: H (2.61), see DeformOptions::curvature_term
};

constexpr auto choices_of(DeformationEnergy) {
  return choices<DeformationEnergy>("deformation energy", {{DeformationEnergy::Stretch, "stretch"},
                                                           {DeformationEnergy::Bend, "bend"},
                                                           {DeformationEnergy::Combined, "combined"},
                                                           {DeformationEnergy::TotalCurvature, "total"}});
}

/// How surface detail is kept where the shape turns (H 2.3.2: min E(X') + λ ‖L X' − δ̂(X')‖²).
enum class DetailPreservation {
  /// Not at all: detail keeps its direction in space.
  None,
  /// Alternates between rotations of the one-rings and positions (H 2.3.3). The differentials of the energy
  /// turn with the one-rings: with Stretch this is "as rigid as possible" [sorkine2007].
  ShapeMatching,
  /// Inexact Gauss–Newton on Laplacian coordinates written in face normals (H 2.3.4, 2.74–2.79).
  GaussNewton,
};

constexpr auto choices_of(DetailPreservation) {
  return choices<DetailPreservation>("way to keep detail",
                                     {{DetailPreservation::None, "none"},
                                      {DetailPreservation::ShapeMatching, "shape-matching"},
                                      {DetailPreservation::GaussNewton, "gauss-newton"}});
}

/// How a Deformer moves what is not given a target.
struct DeformOptions {
  DeformationEnergy energy = DeformationEnergy::TotalCurvature;
  DetailPreservation detail = DetailPreservation::GaussNewton;
  /// 0: handles are met exactly (hard constraints). Positive: they pull, with this weight relative to the
  /// mean diagonal entry of the energy's matrix (2.63–2.66); 1 is a gentle pull, 1e4 all but exact.
  double soft_weight = 0;
  /// Combined: ℓ = √(k_b / k_s) as a fraction of the bounding-box diagonal, positive. Bending rules below
  /// this size, stretching above.
  double bending_length = 0.1;
  /// TotalCurvature: factor of its curvature term, [0, 1]. The operator may be indefinite
  /// (docs/errata.md#h-2-61): then the factor is halved until it is positive definite, and DeformReport says
  /// so. 0 is Bend.
  double curvature_term = 1;
  /// GaussNewton: λ_2 of (2.67) relative to the bending energy, positive. Small values let the displacement
  /// energy drag details towards their old direction.
  double detail_weight = 1000;
  /// GaussNewton: length ℓ, as a fraction of the bounding-box diagonal, in the membrane term λ_2/ℓ² Σ w ‖e' −
  /// R e‖² over edges e that turn with their one-rings; 0 leaves it out, as H does. Without it a twist
  /// gathers in the middle between its handles (θ'' = 0 there only in the mean) and nothing resists shear;
  /// well below 0.1 a bent tube ovalises rather than stretch.
  double membrane_length = 0.1;
  /// Most iterations of the detail preservation, at least 1.
  int max_iterations = 200;
  /// Stop when no vertex moves by more than this fraction of the bounding-box diagonal; positive. H: 1e-6.
  double tolerance = 1e-6;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How the preservation of detail went.
struct DeformReport {
  int iterations = 0;
  /// Largest move of a vertex in the last iteration, as a fraction of the bounding-box diagonal.
  double last_move = 0;
  bool converged = true;
};

/// Deforms one mesh with one choice of constrained vertices, any number of times: the matrix is factorised in
/// the constructor, so that a drag costs a back-substitution (per iteration, where detail is preserved).
class Deformer {
 public:
  /// @param constrained the vertices that will be given targets: fixed ones and handles, in any order.
  /// @throws InvalidInput on a vertex out of range or named twice, a part of the mesh without any constrained
  /// vertex (its place is open), a triangle list that is no oriented manifold, or an option out of range.
  /// @throws SolverFailure when the system is not positive definite (degenerate triangles); Cancelled.
  Deformer(const Points& positions, const Triangles& triangles, std::vector<int> constrained,
           const DeformOptions& options = {}, const Progress& progress = {});
  ~Deformer();
  Deformer(Deformer&&) noexcept;
  Deformer& operator=(Deformer&&) noexcept;

  /// The deformed mesh; its triangles are those of the input.
  struct Result {
    Points positions;  ///< n × 3
    DeformReport report;
  };
  /// @param targets one row per constrained vertex, in the order given to the constructor.
  /// @param start where the iterations begin (n × 3): the result of the last drag, say. By default the linear
  /// solution.
  /// @throws InvalidInput on targets of the wrong number or not finite. Cancelled through `progress`.
  Result deform(const Points& targets, const Points* start = nullptr, const Progress& progress = {}) const;

  /// The vertices that are given targets, in the order of the constructor.
  const std::vector<int>& constrained() const;
  /// The factor of the curvature term in use: below DeformOptions::curvature_term where the operator would
  /// have been indefinite. 0 for other energies.
  double curvature_term() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace batten
