#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/units.hpp"
#include "batten/implicit/stroke_field.hpp"
#include "batten/pipeline/network_surface.hpp"

namespace batten {

/// Options of implicit_surface().
struct ImplicitSurfaceOptions {
  StrokeFieldOptions field;
  /// Length of the edges; relative: of the diameter of the strokes. Nothing: kImplicitEdge of it.
  std::optional<Length> edge_length;
  double max_triangles = 20e6;  ///< as in SurfaceOptions

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

constexpr double kImplicitEdge = 0.015;
constexpr double kUnsureDistance = 0.1;  ///< of UnsurePlace, ÷ diameter

/// A part of a surface that no stroke is near.
struct UnsurePlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< where it is farthest from all strokes
  double area = 0;                                     ///< ÷ that of the surface
  double distance = 0;                                 ///< of that position from the strokes, ÷ diameter
};

/// A surface without patches, and the field whose zero it is.
struct ImplicitSurface {
  /// With the gradients as normals; of a network it has the figures that apply: mesh, topology, quality,
  /// diameter, curves, crossings, flaws, warnings, times.
  NetworkSurface surface;
  StrokeFieldResult field;
  /// From the samples of the strokes to the surface ÷ diameter: 95th percentile and largest.
  double stroke_distance_p95 = 0, stroke_distance_max = 0;
  /// Parts farther than kUnsureDistance from all strokes, the largest first: the field alone says how they
  /// look.
  std::vector<UnsurePlace> unsure;
};

/// The surface of strokes that need not meet: the zero of the smoothest field through them (stroke_field()),
/// with vertices on the strokes (level_set()). Closed around them, unless options.field.closed is false: then
/// it goes on beyond them, and is open where it leaves their box by a fifth of the diameter.
/// Flaws: openings where it should be closed, triangles that cross, strokes far from it.
/// @throws InvalidInput, SolverFailure, Cancelled.
ImplicitSurface implicit_surface(const CurveNetwork& strokes, const ImplicitSurfaceOptions& options = {},
                                 const Progress& progress = {});

}  // namespace batten
