#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/linalg/iterative.hpp"

namespace batten {

/// How fair_automatically() treats a mesh.
enum class FairingStrategy {
  None,     ///< not at all: it looks clean
  Sharp,    ///< as a part with edges: narrow range, wide neighbourhood
  Organic,  ///< as a grown or carved shape: wide range, narrow neighbourhood
};

constexpr auto choices_of(FairingStrategy) {
  return choices<FairingStrategy>("fairing strategy", {{FairingStrategy::None, "none"},
                                                       {FairingStrategy::Sharp, "sharp"},
                                                       {FairingStrategy::Organic, "organic"}});
}

/// Options of fair_automatically().
struct AutomaticFairingOptions {
  /// Noise along the normals (standard deviation) in mean edge lengths; negative: estimate_noise().
  double noise = -1;
  /// Rounds of filter and refit; 0 takes 12 for sharp and 10 for organic shapes. Sharp ones get two more, in
  /// which vertices may leave their normals.
  int iterations = 0;
  /// Keep border vertices where they are.
  bool keep_boundary = false;
  /// The first problem found, in words, or nothing.
  std::string problem() const;
};

/// What fair_automatically() found out and did.
struct AutomaticFairingReport {
  double noise = 0;  ///< in mean edge lengths, given or estimated (and measured again on what was removed)
  double significance = 1;  ///< 0 where the mesh was found clean and left alone; scales the moves
  /// One entry per strategy tried, in the order of `strategies`.
  std::vector<FairingStrategy> strategies;
  /// Stein's estimate of the error of the normals over the whole mesh, in units of the noise's own. (What
  /// decides is the median of its difference over regions.)
  std::vector<double> risks;
  FairingStrategy strategy = FairingStrategy::None;  ///< the one taken
  double exceptions = 0;                             ///< share of the vertices in regions that took the other
  int iterations = 0;                                ///< its rounds
  double largest_move = 0;                           ///< in the unit of the mesh
  SolveQuality solves;                               ///< the refits of all runs
};

/// Removes noise from a mesh, keeping sharp edges sharp and organic shapes organic, without parameters.
///
/// Vertices move along their normals, by t (n unknowns), in rounds of three steps:
///  1. the normals of the triangles are averaged with weights exp(−d²/2s²) exp(−|N − N'|²/2r²) · area over
///     the neighbourhood (the nonlocal weights of H (2.21) on normals instead of curvatures);
///  2. t is refitted from the noisy mesh: min Σ_f Σ_k cot_k (n_f · (x_i − x_j))² + Σ_v λ_v t_v², so that the
///     edges become perpendicular to the filtered normals (H section 2.1.5, step 2, with normals in the
///     place of curvature normals);
///  3. λ_v follows the residual: where the removed part, averaged over the one-ring, is larger than white
///     noise of the known level can be, shape was removed, and λ_v grows; elsewhere it falls.
///
/// Two strategies (narrow range and wide neighbourhood for sharp parts, the opposite for organic ones) are
/// run twice, the second time on slightly perturbed input, and judged by Stein's unbiased risk estimate
/// ([stein1981]; [ramani2008] for the perturbation) of the error of the normals; the one that is
/// better at most places is taken, but for regions where the other is better beyond doubt.
///
/// Triangles that noise along the surface has folded over are turned back by sliding their vertices. A closed
/// mesh keeps the volume of the input, and there are no more self-intersections than in the input (moves that
/// make new ones are taken back by halves, at the cost of some 0.001 % of the volume). Deterministic.
/// @return the new positions.
/// @throws InvalidInput on bad options, indices out of range, positions that are not finite, or a mesh that
/// is not manifold and consistently oriented (naming the place); Cancelled.
Points fair_automatically(const Points& positions, const Triangles& triangles,
                          const AutomaticFairingOptions& options = {},
                          AutomaticFairingReport* report = nullptr, const Progress& progress = {});

}  // namespace batten
