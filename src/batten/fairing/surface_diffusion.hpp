#pragma once
#include <optional>
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Options of surface_diffusion(). The defaults are those of the thesis's Table 2.2.
struct SurfaceDiffusionOptions {
  /// Weights exp(−|H_i − H_j|²/σ) on the diffusion (NL-SDF); false: W = 1 (SDF).
  bool nonlocal = true;
  /// σ of (2.30) for H scaled to a maximum of 1; 0.5–0.6 in the thesis. Smaller keeps sharper features.
  double similarity = 0.6;
  /// Diffuse the scalar curvature H · N and put it back on the normals of the input, for noise along them;
  /// false: the vector.
  bool scalar = false;
  int steps = 10;         ///< n_MAX of step 1; up to 20 in the thesis
  double time_step = 0;   ///< τ, no unit (rows of L are normalised); 0 takes e / max‖LX‖ (1.45)
  double fidelity = 0.5;  ///< λ of step 2, no unit
  bool keep_boundary = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What it did.
struct SurfaceDiffusionReport {
  double time_step = 0;
  double largest_move = 0;  ///< in the unit of the mesh
};

/// (Nonlocal) surface diffusion in two steps, H section 2.1.5:
///  1. diffuse the mean curvature normals H = LX, (I − τ L_w) H⁺ = H, with L_w = Σ W_ij w_ij (2.27–2.30);
///  2. refit: min ‖LX − H‖² + λ‖X0 − X‖².
/// L has normalised rows (1.16), cotangents clamped at a small positive value; the sign is H = +LX (with that
/// of (2.35) the surface turns inside out). W leaves out the normalisation of (2.30), which would not be
/// symmetric, and follows H from step to step. Only λ holds the volume.
/// @throws InvalidInput on bad options or meshes; SolverFailure; Cancelled.
Points surface_diffusion(const Points& positions, const Triangles& triangles,
                         const SurfaceDiffusionOptions& options = {},
                         SurfaceDiffusionReport* report = nullptr, const Progress& progress = {});

}  // namespace batten
