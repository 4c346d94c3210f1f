#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/index.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

// Private to the room.
namespace batten::detail {

/// The cage at one level, with what the rules need.
struct CageLevel {
  PolygonMesh mesh;
  CageTopology topology;
  std::vector<double> interval;        ///< knot interval per edge
  std::vector<double> edge_sharpness;  ///< per edge, what is left
  std::vector<double> vertex_sharpness;
  std::vector<int> polyline;      ///< per edge an index into `polylines`, or −1
  std::vector<Points> polylines;  ///< as the edge runs
  std::vector<VertexKind> kind;   ///< per vertex

  Eigen::RowVector3d point(int vertex) const { return mesh.positions.row(vertex); }
  int vertex(int corner) const { return mesh.corners[at(corner)]; }
  int end_vertex(int corner) const { return vertex(topology.next[at(corner)]); }
  int edge(int corner) const { return topology.edge_of_corner[at(corner)]; }
  int n_corners(int face) const { return mesh.offsets[at(face) + 1] - mesh.offsets[at(face)]; }
  bool is_sharp(int e) const { return topology.sides[at(e)][1] < 0 || edge_sharpness[at(e)] > 0; }
};

/// Counts the sharp and border edges at every vertex (H 6.4). @param smooth_corners as in SubdivisionOptions.
void find_kinds(CageLevel& level, bool smooth_corners);

/// The cage itself: knot intervals are lengths of edges, or of their polylines, to options.knot_exponent.
/// @throws InvalidInput naming a polyline that does not fit its edge, and sharpness as edge_sharpness().
CageLevel base_level(const ControlCage& cage, const CageTopology& topology,
                     const SubdivisionOptions& options);

/// An edge as it leaves one of its vertices.
struct CageSpoke {
  int edge = -1;
  int to = -1;  ///< its other vertex
};

/// The edges around a vertex, counter-clockwise. At the border from border to border.
void spokes_around(const CageLevel& level, int vertex, std::vector<CageSpoke>& spokes);

/// The mean of the corners of a face.
Eigen::RowVector3d centroid(const CageLevel& level, int face);

}  // namespace batten::detail
