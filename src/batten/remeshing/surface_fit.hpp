#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/linalg/iterative.hpp"
#include "batten/remeshing/area_samples.hpp"

namespace batten {

/// What a fit minimises.
struct SurfaceFitOptions {
  /// Weight of the normals, in mean edge lengths squared: with 1 a slope of one part in a hundred over an
  /// edge counts as much as a distance of a hundredth of it. At least 0.
  double normals = 0.1;
  /// No vertex moves by more than this many lengths of its shortest edge.
  double most = 0.25;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What a fit reached.
struct SurfaceFitResult {
  Points positions;       ///< the new ones; as they were where the solve failed
  IterativeReport solve;  ///< `converged` is false where it stopped early or failed
};

/// Moves the vertices of a mesh along their normals to where its triangles fit another surface best:
/// least squares of the distances of points spread over the reference to the mesh, and of the angles between
/// the normals there. Vertices that lie on a curved surface leave all of it on one side; here the error is
/// spread over both sides.
/// @param fixed per vertex: 1 for those that stay. @param reference samples with their nearest triangles of
/// the mesh, as sample_reference() finds them. One linear solve; call again to refine. @throws Cancelled.
SurfaceFitResult fitted_to_surface(const Points& positions, const Triangles& triangles,
                                   const std::vector<char>& fixed, const ReferenceSamples& reference,
                                   const SurfaceFitOptions& options = {}, const Progress& progress = {});

}  // namespace batten
