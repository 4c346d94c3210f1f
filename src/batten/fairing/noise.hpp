#pragma once
#include <cstdint>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Mean length of the edges, each counted once; 0 without triangles. The yardstick of noise: all amplitudes
/// below are in mean edge lengths.
double mean_edge_length(const Points& positions, const Triangles& triangles);

/// Moves every vertex along its normal by a normally distributed amount: what a range scanner adds.
/// @param level standard deviation in mean edge lengths, at least 0.
/// @throws InvalidInput when `level` is negative or not finite.
Points add_gaussian_noise(const Points& positions, const Triangles& triangles, double level,
                          std::uint64_t seed);

/// How add_impulsive_noise() moves the vertices that it hits.
enum class ImpulseKind {
  AlongNormal,      ///< by `level` to either side
  NormalGaussian,   ///< along the normal, normally distributed with standard deviation `level`
  RandomDirection,  ///< by `level` in a direction uniform on the sphere
};

/// Moves a random share of the vertices, and leaves the others where they are: outliers of matching.
/// @param share of the vertices, 0 … 1, each drawn on its own.
/// @param level in mean edge lengths, at least 0.
/// @throws InvalidInput when `share` or `level` is out of range.
Points add_impulsive_noise(const Points& positions, const Triangles& triangles, double share, double level,
                           ImpulseKind kind, std::uint64_t seed);

/// The thesis's noise H (2.36): (c1 N + c2 v) ē with v a random direction and c1, c2 drawn uniformly from
/// ± their bounds, for every vertex anew. (Printed with a division by ē, and with one c1 and c2 for all.)
/// @param normal_level, random_level the bounds of c1 and c2, at least 0.
Points add_thesis_noise(const Points& positions, const Triangles& triangles, double normal_level,
                        double random_level, std::uint64_t seed);

/// An estimate of the noise on a mesh from the mesh alone.
struct NoiseEstimate {
  /// Standard deviation of the vertices along their normals, in mean edge lengths.
  double level = 0;
  /// The part of the level that is surely noise: noise_significance() without doubt.
  double significance = 0;
  /// The same deviation in the calmest regions of the mesh: noise is as large everywhere, shape is not. What
  /// the shape of clean meshes adds is mostly less than to the level (nothing on parts with flat faces,
  /// 0.004–0.016 on scans, 0.03–0.06 on coarse or carved ones); noise of 0.02–0.05 comes out 1–1.4 times as
  /// large.
  double floor = 0;
};

/// The part of an estimated noise level (in mean edge lengths) that is surely noise: none of it below a bar,
/// where clean meshes come as well, all of it from 0.03 above it. The bar is 0.05 for shapes that are smooth
/// at the scale of their triangles; it rises by 0.1 times `doubt`, a share of the level that speaks for
/// shape.
double noise_significance(double level, double doubt);

/// The bi-umbrella (I − P)² X, P the mean of the neighbours, projected on smoothed vertex normals: smooth
/// shapes hardly show in it, noise does by a factor known per vertex. The median over the vertices makes it
/// blind to edges. Within 20 % of the truth for 0.1–0.3 mean edge lengths on the meshes of the tests; a clean
/// scan of an organic shape gives 0.025, a coarse one up to 0.06.
NoiseEstimate estimate_noise(const Points& positions, const Triangles& triangles,
                             const Progress& progress = {});

}  // namespace batten
