#pragma once
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"

namespace batten {

/// One traced curve: a walk over vertices of the network. A closed curve repeats its first vertex at the end.
struct NetworkCurve {
  std::string name;           ///< as given by the file, or empty
  bool boundary = false;      ///< lies on the border of an open surface
  std::vector<int> vertices;  ///< indices into CurveNetwork::positions; at least two
  /// The surface has an edge here: it is smooth on both sides, not across. See split_at_sharp_curves().
  bool sharp = false;
  /// Of a sharp curve: unit outward normals of the surface to its left and right (looking along the curve,
  /// from outside), one per entry of `vertices`, or 0 × 3 where they are unknown.
  Points left_normals = Points(0, 3), right_normals = Points(0, 3);

  bool closed() const { return vertices.size() > 2 && vertices.front() == vertices.back(); }
};

/// A curve network with positions: what `batten network` writes and `batten surface` reads.
/// Curves meet where they share a vertex; coordinates are never compared to find out.
struct CurveNetwork {
  Points positions;  ///< n × 3
  Points normals;    ///< n × 3 unit outward normals, or 0 × 3 where the source has none
  std::vector<NetworkCurve> curves;
  /// Vertices that the source names as nodes although the topology alone would not show them (the end of a
  /// scan's node list); every vertex of degree other than 2 is a node as well. See NetworkTopology.
  std::vector<int> tagged_nodes;
  /// Unit of length as written in the file ("m", "mm", …), or empty.
  std::string unit;

  bool has_normals() const { return normals.rows() == positions.rows() && positions.rows() > 0; }
};

/// A piece of a curve between two nodes, without a node inside.
struct NetworkSegment {
  int curve = -1;             ///< index of the curve that it is a part of
  bool boundary = false;      ///< of that curve
  std::vector<int> vertices;  ///< from node to node, both included; first == last for a loop
  /// Node numbers (indices into NetworkTopology::nodes) of the two ends; equal for a loop.
  int from = -1, to = -1;
};

/// Nodes and segments of a network, derived from its curves.
struct NetworkTopology {
  /// Vertices where curves end, cross or are tagged. A closed curve that meets nothing gets its first vertex.
  std::vector<int> nodes;
  std::vector<NetworkSegment> segments;
  std::vector<int> node_of_vertex;     ///< per vertex: its node number, or −1
  std::vector<int> component_of_node;  ///< per node: 0 … n_components − 1
  int n_components = 0;
};

/// How errors and warnings call a curve: "curve 3", counted from 0 as in the file, with its name if it has
/// one.
std::string curve_name(const CurveNetwork& network, int curve);

/// @throws InvalidInput when an index is out of range, a curve has fewer than two vertices or repeats a
/// vertex.
NetworkTopology network_topology(const CurveNetwork& network);

/// A patch to be filled: one or more closed boundary loops of network vertices. Seen from outside, loops run
/// counter-clockwise around the patch (the patch lies to their left). No vertex is repeated at the end.
struct NetworkCycle {
  /// One closed walk along segments.
  struct Loop {
    std::vector<int> vertices;
    /// The segments in the order of the walk; ~s for segment s walked backwards.
    std::vector<int> segments;
  };
  std::vector<Loop> loops;
  std::string name;  ///< what messages call its patch; empty: by its number and its first vertex
};

/// What find_cycles() found, with everything worth telling in words.
struct CycleReport {
  std::vector<NetworkCycle> cycles;
  std::vector<std::string> warnings;
};

/// Traces the patches of the network by the order of the segments around each node in its tangent plane
/// (S 4.4.1, algorithm 4.9 corrected as in docs/errata.md#s-4-9). Walks made only of boundary segments from
/// outside are no patches. Loops of components that are not connected are joined into patches with several
/// boundary loops where they face each other (S fig. 4.18) and where that leaves less total curvature to the
/// patch (Gauss-Bonnet) than two patches would have. Loops and cycles come in an order that depends on the
/// positions alone, not on the order of curves and vertices in the network.
/// @throws InvalidInput when the network has no normals, a position is not finite, an edge has no length, a
/// curve ends in nothing, or a border is not tagged, with curve and node.
CycleReport find_cycles(const CurveNetwork& network);

}  // namespace batten
