#pragma once
#include <array>
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten::detail {

/// A piece of a curve between two nodes, in which at most two pieces of the surface meet.
struct OutlineSegment {
  std::vector<int> vertices;  ///< of the mesh, in order; the first and the last are nodes
  bool is_sharp = false;
};

/// A side of a piece: a segment and whether the piece runs along it forwards, the surface to its left.
struct OutlineSide {
  int segment = 0;
  bool forward = true;
};

/// A part of the surface with one outline, like a disc.
struct OutlinePiece {
  int patch = 0;
  std::vector<int> triangles;
  std::vector<OutlineSide> sides;  ///< around it, counter-clockwise
  std::vector<char>
      is_flat;  ///< per side: its first node lies between sides that go on straight (more than 150°)
};

/// The pieces of a mesh with patches, and the curves between them.
struct PatchOutlines {
  std::vector<OutlineSegment> segments;
  std::vector<OutlinePiece> pieces;
};

/// Cuts patches that are no discs along shortest paths, finds nodes (ends of curves, kinks) and adds nodes
/// until every piece can be divided into quads: three corners and nothing flat, or four nodes.
/// @throws InvalidInput as quad_layout().
PatchOutlines patch_outlines(const Points& positions, const Triangles& triangles,
                             const std::vector<int>& patch_of_triangle, double crease_angle);

}  // namespace batten::detail
