#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/network/curve_network.hpp"

// What every step of cleaning asks of a network. Private to the room.
namespace batten::detail {

inline Eigen::Vector3d position(const CurveNetwork& network, int v) {
  return network.positions.row(v);
}

/// Of the polyline through these vertices.
double length_of(const CurveNetwork& network, const std::vector<int>& vertices);

/// "(x, y, z)"
std::string coordinates(const Eigen::Vector3d& p);

/// The network with vertices that no curve uses dropped; the others keep their order.
CurveNetwork compacted(CurveNetwork network);

/// Every segment a curve of its own.
CurveNetwork in_segments(const CurveNetwork& network);

}  // namespace batten::detail
