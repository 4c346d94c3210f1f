#pragma once
#include <array>
#include <vector>

#include "batten/mesh/control_cage.hpp"

// Private to the room.
namespace batten::detail {

/// Corners are counted in int, and OpenSubdiv needs some 150 bytes for each face.
constexpr double kMostFaces = 1e8;

/// Which edges the faces of a polygon mesh share. Corner c stands for the side from its vertex to the next
/// corner of its face.
struct CageTopology {
  std::vector<std::array<int, 2>> edges;  // as the first face runs along them
  std::vector<std::array<int, 2>> sides;  // per edge its one or two corners; −1 on the border
  std::vector<int> edge_of_corner;
  std::vector<int> next, previous;  // per corner, in its face
  std::vector<int> face_of_corner;
  std::vector<int> corner_of_vertex;  // one corner; at the border the one whose side is on the border
  std::vector<char> is_border;        // per vertex

  int opposite(int corner) const {
    const std::array<int, 2>& both = sides[static_cast<size_t>(edge_of_corner[static_cast<size_t>(corner)])];
    return both[0] == corner ? both[1] : both[0];
  }
};

/// Linear time. @throws InvalidInput naming what is no oriented manifold, and the remedy.
CageTopology cage_topology(const PolygonMesh& mesh);

/// The edge between two vertices. @throws InvalidInput when there is none; `what` names who asks.
int edge_between(const CageTopology& topology, const PolygonMesh& mesh, int from, int to, const char* what);

/// Sharpness per edge and per vertex, 0 where the cage says nothing. @throws InvalidInput.
std::vector<double> edge_sharpness(const ControlCage& cage, const CageTopology& topology);
std::vector<double> vertex_sharpness(const ControlCage& cage);

/// What is left of a sharpness after so many levels; from 10 on it lasts for ever.
double sharpness_after(double sharpness, int levels);

/// How a vertex behaves for the edges around it (H 6.4): counted over sharp and border edges.
enum class VertexKind { Smooth, Dart, Crease, Corner };

}  // namespace batten::detail
