#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// Private to the room.
namespace batten::detail {

/// The plane in which a surface lies at a vertex of the model, from the drawn curves that meet there: its
/// unit normal, with either sign; zero where they do not tell.
Eigen::Vector3d normal_of_curves_at(const PolylineMesh& mesh, int vertex);

/// n + 1 points along an edge of a model, in its sense. A curve that a tool has made between two vertices is
/// the cubic that leaves and reaches them in the planes of the surface there: a straight line (H 6.4.2)
/// would cut through a round body.
Points course_of_edge(const PolylineMesh& mesh, const SketchEdge& edge, int n);

}  // namespace batten::detail
