#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/simulation/mesh_polylines_detail.hpp"

// Private to the room.
namespace batten::detail {

/// A crossing as a place on a polyline.
struct CrossingPlace {
  std::size_t piece;
  double fraction;  ///< along the piece
  int node;         ///< which of the crossings
};

/// A crossing as a point of the mesh.
struct MeshCrossing {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;  ///< unit, of the mesh
};

/// The points where polylines on a mesh cross: sections of different axes in a common face, and open sections
/// at the borders where they end.
struct PolylineCrossings {
  std::vector<MeshCrossing> crossings;
  std::vector<std::vector<CrossingPlace>> places;  ///< per polyline, in its order
};

/// Linear in the pieces where few sections share a face.
PolylineCrossings find_crossings(const std::vector<MeshPolyline>& lines);

/// Keeps the polylines that hang together with the longest part.
/// @param warnings gain what is left out.
void keep_connected(std::vector<MeshPolyline>& lines, std::vector<std::string>& warnings);

}  // namespace batten::detail
