#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/subdivision/bspline_surface.hpp"

namespace batten {

/// Options of spline_faces().
struct SplineFacesOptions {
  /// Distance between the vertices of the mesh and the faces to reach, relative to the diameter; above 0.
  /// Faces get more knots until they reach it, or have as many as their vertices can determine.
  double tolerance = 1e-4;
  /// Curves at which the surface turns by more than this in the median become sharp edges; radians, in (0,
  /// π].
  double crease_angle = radians(20.0);
  /// More faces than this are refused before anything is fitted; at least 1.
  int most_patches = 20000;
  /// Most knot spans along a side of a face, 1 to 64. The cost grows with their square.
  int most_spans = 32;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A surface of few faces for CAD.
struct SplineFaces {
  /// Faces share their edges and vertices; `patches[i].face` is the patch of the mesh that a face lies in,
  /// `deviation` the largest distance of a vertex from its face, in the unit of the mesh, and `normal_jump`
  /// as there.
  BsplineSurface surface;
  double rms_deviation = 0;  ///< root of the mean square of these distances
  int n_sharp = 0;           ///< edges inside the surface
};

/// Bicubic B-spline faces through a mesh of patches, such as fills the cells of a curve network: one face for
/// a patch with four corners, some for others, all meeting side to side along the same curves. Fitted
/// together by least squares of the distances to the vertices, with equal tangent planes at both sides of
/// every curve that is not sharp, in turns with the parameters of the vertices (their nearest points)
/// [hoschek1988].
/// @param patch_of_triangle  one number per triangle; curves run where it changes.
/// @throws InvalidInput where the mesh is not an oriented manifold, a patch has handles or too few vertices
/// (named, with its place), or options are out of range; SolverFailure; Cancelled. Time and memory grow
/// linearly with vertices and faces.
SplineFaces spline_faces(const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                         const SplineFacesOptions& options = {}, const Progress& progress = {});

}  // namespace batten
