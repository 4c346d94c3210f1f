#pragma once
#include "batten/implicit/hermite_field.hpp"

namespace batten {

/// Slopes of length 1 at every site, as unit vectors of the plane across the stroke.
struct FoundSlopes {
  Eigen::VectorXd slopes;  ///< 2 n; each pair has length 1
  double energy = 0;       ///< sᵀ H s + 2 pᵀ s
  int starts = 0;          ///< from which the search went down
  int sweeps = 0;          ///< over all sites, of the start that won
};

/// The unit slopes of least energy: where the surface's normals point, and to which side ([huang2019], with
/// one angle per site where the direction of the stroke is known). The energy has many valleys; the search
/// goes down from several starts (the slopes that the values have, and the smoothest slopes of all, whichever
/// sides they take) and keeps the best. Each step turns one site to the best of all its angles, the others
/// held. Deterministic. O(n²) per sweep.
/// @throws Cancelled.
FoundSlopes find_slopes(const SlopeEnergy& energy, const Progress& progress = {});

/// The same from one start: the valley that it lies in.
/// @param start 2 n; pairs of any length but 0.
FoundSlopes descended_slopes(const SlopeEnergy& energy, const Eigen::VectorXd& start);

}  // namespace batten
