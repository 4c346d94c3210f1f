#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// Edge lengths of triangles, m × 3: column k holds the edge opposite corner k. Everything that a Laplacian
/// needs; the corners need not be embedded anywhere.
using EdgeLengths = Points;

/// Lengths of the edges of an embedded mesh.
EdgeLengths edge_lengths(const Points& positions, const Triangles& triangles);

/// Area of a triangle from its sides (Kahan's form of Heron's formula, accurate for needles); 0 where they
/// violate the triangle inequality.
double triangle_area(double a, double b, double c);

/// For every half-edge 3f + k (the edge opposite corner k of triangle f) the half-edge on its other side, −1
/// on a border. The mesh must be manifold and consistently oriented.
/// @throws InvalidInput naming the two triangles that share a directed edge.
std::vector<int> opposite_half_edges(const Triangles& triangles);

/// An intrinsic triangulation: the same vertices and metric as a mesh, other edges.
struct IntrinsicTriangulation {
  Triangles triangles;
  EdgeLengths lengths;
  int flips = 0;
};

/// Flips edges, in the metric given by their lengths, until every inner edge is Delaunay [fisher2007].
/// Its cotangent weights are never negative.
/// Edges marked in `fixed` (per half-edge 3f + k, or empty) and flips that would join a vertex to itself or
/// make a double edge are left out.
IntrinsicTriangulation intrinsic_delaunay(const Triangles& triangles, const EdgeLengths& lengths,
                                          const std::vector<char>& fixed = {});

}  // namespace batten
