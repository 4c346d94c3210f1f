#pragma once
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Options of the geometric flows ∂X/∂t = …, all of which rebuild their operator in every step.
struct FlowOptions {
  /// τ, in length² for flows of second order and length⁴ for those of fourth; 0 takes the thesis's rules in
  /// every step: implicit e / max‖ΔX‖ (1.45), for fourth order e / max‖Δ²X‖; explicit min e²/2 (1.44), but
  /// not beyond the stability bound of the matrix, which that rule can exceed on cotangents.
  double time_step = 0;
  int steps = 10;  ///< at least 0
  /// Backward Euler, stable for every τ; false: forward Euler.
  bool implicit = true;
  /// λ ≥ 0 of the pull λ(X0 − X) towards the input (2.26), in 1 / (unit of τ).
  double fidelity = 0;
  /// Keep border vertices in place (Dirichlet constraints, H section 1.3).
  bool keep_boundary = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What a flow did.
struct FlowReport {
  double time_step = 0;     ///< of the last step
  int steps = 0;            ///< taken; fewer than asked where nothing was left to smooth
  double largest_move = 0;  ///< from the input, in the unit of the mesh
};

// All flows return new positions, throw InvalidInput on bad options or a mesh that is not manifold and
// oriented (naming the place), SolverFailure, and Cancelled.

/// Mean curvature flow ∂X/∂t = ΔX: (2.3) explicit, (2.4) implicit in its symmetric form (M + τK) X' = M X.
Points mean_curvature_flow(const Points& positions, const Triangles& triangles,
                           const FlowOptions& options = {}, FlowReport* report = nullptr,
                           const Progress& progress = {});

/// Bi-Laplacian flow ∂X/∂t = −Δ²X: (2.6) explicit, (2.8) implicit, (M + τ K M⁻¹ K) X' = M X.
Points bilaplacian_flow(const Points& positions, const Triangles& triangles, const FlowOptions& options = {},
                        FlowReport* report = nullptr, const Progress& progress = {});

/// The diffusivity f(s) = 1/(1 + (s/ν)²), (2.9) turned right way up: 1 on flat parts, 0 across edges.
double edge_stopping(double curvature, double threshold);

/// Options of the anisotropic flows.
struct AnisotropicFlowOptions : FlowOptions {
  /// ν in 1/length: curvatures well above it are kept; 0 takes 1/ē, with the tensor 0.3/ē. H names none.
  double threshold = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Anisotropic mean curvature flow with the scalar diffusivity of the mean curvature, ∂X/∂t = f(|H|) ΔX.
/// (2.10–2.11), whose gradient term is tangential and falls away in the projection on the normal.
Points anisotropic_flow(const Points& positions, const Triangles& triangles,
                        const AnisotropicFlowOptions& options = {}, FlowReport* report = nullptr,
                        const Progress& progress = {});

/// The same with the tensor of (2.13–2.14): div(D ∇X) with D = f(κ1) v1 v1ᵀ + f(κ2) v2 v2ᵀ on each triangle,
/// so that smoothing runs along edges and not across. Moves are projected on the vertex normals (2.10).
Points anisotropic_tensor_flow(const Points& positions, const Triangles& triangles,
                               const AnisotropicFlowOptions& options = {}, FlowReport* report = nullptr,
                               const Progress& progress = {});

/// Elastica (Willmore) flow: normal velocity ΔH + 2H(H² − K) with H = (κ1 + κ2)/2 (1.38), the steepest
/// descent of ½∫κ1² + κ2². Spheres do not move. Implicit: the leading part ½Δ²X of the velocity is taken at
/// the end of the step.
Points elastica_flow(const Points& positions, const Triangles& triangles, const FlowOptions& options = {},
                     FlowReport* report = nullptr, const Progress& progress = {});

/// Options of nonlocal_flow().
struct NonlocalFlowOptions : FlowOptions {
  /// σ of the similarity exp(−|H_i − H_j|²/σ), H scaled to a maximum of 1 (2.30). Smaller keeps more.
  double similarity = 0.5;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The nonlocal position flow ∂X/∂t = L_w X + λ(X0 − X) (2.22–2.28): cotangent weights times the similarity
/// of mean curvature normals, without the normalisation of (2.30), which would not be symmetric.
Points nonlocal_flow(const Points& positions, const Triangles& triangles,
                     const NonlocalFlowOptions& options = {}, FlowReport* report = nullptr,
                     const Progress& progress = {});

/// Options of taubin_smoothing().
struct TaubinOptions {
  double lambda = 0.5;  ///< weight of the shrinking half of a step, in (0, 1]
  double mu = -0.53;    ///< of the growing half, below −lambda
  int steps = 10;
  bool keep_boundary = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Taubin's λ|μ smoothing [taubin1995] with the umbrella: a low-pass filter that hardly shrinks. The filter
/// most used on organic shapes; here for comparison.
Points taubin_smoothing(const Points& positions, const Triangles& triangles,
                        const TaubinOptions& options = {}, const Progress& progress = {});

}  // namespace batten
