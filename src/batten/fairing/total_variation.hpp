#pragma once
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// How a field is held to its data.
enum class TotalVariationFit {
  L2,  ///< μ/2 ∫(φ − f)², (2.16): Gaussian noise
  L1,  ///< μ ∫|φ − f|: outliers; contrast is kept
};

/// Options of denoise_total_variation().
struct TotalVariationOptions {
  /// μ > 0, weight of the fit: in (unit of f)⁻¹ / length for L2, 1 / length for L1. Larger keeps more.
  double fit_weight = 1;
  TotalVariationFit fit = TotalVariationFit::L2;
  int iterations = 200;  ///< of the dual iteration, at least 1

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What was reached.
struct TotalVariationReport {
  double energy = 0;  ///< TV(φ) + fit, of the result
  /// L2: energy minus the value of the dual problem, at least 0: how far from the optimum at most. 0 for L1.
  double gap = 0;
};

/// ∫|∇φ| over the mesh of a field per vertex (n × c; channels are coupled by the Frobenius norm). (2.15)
double total_variation(const Points& positions, const Triangles& triangles, const Eigen::MatrixXd& field);

/// Minimises TV(φ) + fit to f (n × c, per vertex) by Chambolle's dual iteration [chambolle2004],
/// V ← (V + τ∇(div V − μf)) / (1 + τ|∇(div V − μf)|), φ = f − div V/μ, with V per triangle, div the exact
/// negative adjoint of ∇ and τ = 1/‖div‖² (the thesis prints 1/‖div‖, with which it diverges). The L1 fit
/// alternates it with soft thresholding [aujol2006].
/// On positions, TV is mean curvature flow (2.18): apply it to normals and scalar fields.
/// @return n × c.
/// @throws InvalidInput on bad options or sizes; Cancelled.
Eigen::MatrixXd denoise_total_variation(const Points& positions, const Triangles& triangles,
                                        const Eigen::MatrixXd& field,
                                        const TotalVariationOptions& options = {},
                                        TotalVariationReport* report = nullptr,
                                        const Progress& progress = {});

}  // namespace batten
