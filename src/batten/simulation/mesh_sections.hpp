#pragma once
#include <optional>
#include <string>

#include "batten/mesh/triangle_mesh.hpp"
#include "batten/simulation/traced_curve.hpp"

namespace batten {

/// Which plane sections of a mesh are scanned.
struct MeshSectionOptions {
  /// Planes per axis, evenly spread over the bounding box; 1 … 100.
  int planes = 3;
  /// The axes that planes are laid across: some of x, y and z, each once. Two at least, or nothing crosses.
  std::string axes = "xyz";
  /// Distance of the knots of the smooth curves, in diameters; 0: the mean edge of the mesh, 0.5 % to 2 %.
  double knot_spacing = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Curves on a triangle mesh: its sections with planes, and its border loops as boundary curves. A border
/// that no plane meets gets one of its own.
///
/// A section of a mesh is a polyline with a kink at every edge, which no device would draw. So the curves are
/// cubic splines through points of the polyline, the crossings among them; the truth is the spline. Its
/// frames turn smoothly: normals are interpolated from vertex normals, and at a crossing the normal is at
/// right angles to both curves. Sharp edges of the mesh are rounded over the spacing of the knots.
///
/// Curves that are not connected with the longest part of the network are left out, with a warning.
/// @throws InvalidInput when the mesh is empty, is no oriented manifold (naming a face), when no plane meets
/// it, or when nothing crosses.
TracedNetwork trace_mesh(const TriangleMesh& mesh, const MeshSectionOptions& options = {});

}  // namespace batten
