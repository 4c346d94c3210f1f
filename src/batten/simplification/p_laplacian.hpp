#pragma once
#include <optional>
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Weights w(X_i, X_j) of the edges in H (2.94); each is symmetric.
enum class FlowWeight {
  Uniform,        ///< w1: 1
  InverseLength,  ///< w2: 1/(ε + |e|), lengths relative to their mean
  Curvature,      ///< w3: exp(−|H_i − H_j|²/σ), H scaled to largest magnitude 1; not normalised
                  ///< (docs/errata.md#h-2-94)
};

constexpr auto choices_of(FlowWeight) {
  return choices<FlowWeight>(
      "weight of edges",
      {{FlowWeight::Uniform, "w1"}, {FlowWeight::InverseLength, "w2"}, {FlowWeight::Curvature, "w3"}});
}

/// Options of p_laplacian_flow(). Lengths are measured in mean edge lengths, so that nothing depends on
/// scale.
struct PLaplacianOptions {
  double p = 0.1;  ///< exponent, in (0, 2]; below 1 vertices gather at features
  FlowWeight weight = FlowWeight::Curvature;
  /// λ for all vertices, at least 0; without one, λ_i = √(|H_i| + ε) with H scaled to largest magnitude 1.
  std::optional<double> fidelity;
  double time_step = 0.1;  ///< dt, above 0
  int steps = 3;           ///< at least 0
  double epsilon = 1e-4;   ///< ε, above 0: regularises |∇f|^(p−2), lengths and λ
  double sigma = 0.5;      ///< σ of w3, above 0; smaller keeps sharper features

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The p-Laplacian flow of the vertex positions of a mesh, H (2.98) with the signs put right
/// (docs/errata.md#h-2-98): (I + dt L_p + dt Λ) X' = X + dt Λ X⁰, with L_p of (2.95) rebuilt from X in every
/// step. All three coordinates share one matrix (2.96), symmetric positive definite.
/// @return n × 3 positions; vertices without faces and on the border stay.
/// @throws InvalidInput on bad options; SolverFailure; Cancelled.
Points p_laplacian_flow(const Points& positions, const Triangles& triangles,
                        const PLaplacianOptions& options = {}, const Progress& progress = {});

}  // namespace batten
