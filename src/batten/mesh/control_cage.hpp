#pragma once
#include <limits>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// The sharpness that never ends: a crease or a corner at every level.
constexpr double kInfinitelySharp = std::numeric_limits<double>::infinity();

/// An edge of a cage that stays sharp for so many levels of subdivision: 0 is smooth, a fraction blends the
/// last level, 10 and more means for ever [derose1998].
struct SharpEdge {
  int from = 0, to = 0;  ///< vertices joined by an edge of a face, in either order
  double sharpness = kInfinitelySharp;
};

/// A vertex that stays where it is for so many levels.
struct SharpVertex {
  int vertex = 0;
  double sharpness = kInfinitelySharp;
};

/// The curve drawn along an edge of a cage.
struct EdgePolyline {
  int from = 0, to = 0;  ///< vertices joined by an edge of a face
  Points points;         ///< k × 3, k ≥ 2, from the one vertex to the other, both included
};

/// What subdivision starts from: polygons with any number of corners, what is sharp, and the curves that were
/// drawn along edges. Edges that are not named are smooth and straight.
struct ControlCage {
  PolygonMesh mesh;
  std::vector<SharpEdge> sharp_edges;
  std::vector<SharpVertex> sharp_vertices;
  std::vector<EdgePolyline> polylines;
};

}  // namespace batten
