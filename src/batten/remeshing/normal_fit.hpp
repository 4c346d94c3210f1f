#pragma once
#include <optional>
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/remeshing/area_samples.hpp"
#include "batten/remeshing/connectivity.hpp"

namespace batten {

/// What fit_normals() weighs against the normals.
struct NormalFitOptions {
  /// Radians of normal error that one radian of a triangle's smallest angle is worth at first, at least 0.
  double shape = 0.1;
  /// Mean smallest angle to keep, radians: the weight of the shape falls from `shape` as far as it allows.
  double mean_angle = 0.8727;  // 50°
  /// Radians of normal error that a distance of one wanted edge length is worth, at least 0.
  double distance = 1;
  /// Radians of normal error, over the two triangles of an edge, that one unit of Σ (valence − 6)² is worth.
  double valence = 0.05;
  /// No move makes a smallest angle less than this (or than it was), radians.
  double least_angle = 0.6;
  /// Rounds over all vertices and edges, at least 0; a round looks only at what changed in the last.
  int rounds = 6;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Moves vertices and turns edges where the triangles then have normals nearer to those of the reference, at
/// points spread over it by area. What is minimised is Σ a (|n − n_ref| + distance/h) over those points plus
/// the shape terms of the options: the mean error, not its square, because a mesh of a faceted surface can
/// have exact facets nearly everywhere and pay for it at a few edges.
///
/// A free vertex is tried at the nearest vertices of the reference, at the point where the planes of the
/// reference around it meet best, and in the middle of its neighbours; a vertex on a feature chain at the
/// vertices of the chain. Descent by single moves: the sum falls with every one. Vertices are taken in blocks
/// of neighbours, side by side on all threads, then those between the blocks; the order, and the result, do
/// not depend on the number of threads.
/// @param reference (taken over) samples of the reference with their nearest points on
/// state.mesh.compacted(), as sample_reference() finds them; the mesh may have moved a little since.
/// @return the number of moves and turns.
int fit_normals(RemeshState& state, const FeatureChains& features, const Points& reference_positions,
                const Triangles& reference_triangles, ReferenceSamples reference,
                const NormalFitOptions& options = {}, const Progress& progress = {});

}  // namespace batten
