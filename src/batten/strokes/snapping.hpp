#pragma once
#include "batten/network/curve_network.hpp"

namespace batten {

/// What welded() did.
struct WeldReport {
  int n_merged_vertices = 0;  ///< vertices that became one with another
  int n_inserted_nodes = 0;   ///< vertices inserted where curves cross or an end lies on a curve
  int n_removed_curves = 0;   ///< curves that shrank to a point
};

/// The network after welding.
struct WeldedNetwork {
  CurveNetwork network;
  WeldReport report;
};

/// Makes curves meet that come within `tolerance` of each other: ends are merged with ends, an end that lies
/// on another curve gets a vertex there, and two curves that cross get one in common. Each point moves by at
/// most the tolerance. Normals of merged vertices are averaged. Vertices that no curve uses any more are
/// dropped, the others keep their order.
/// @param tolerance in the unit of the network, more than 0 and below the distance of samples that are to
/// stay apart.
/// @throws InvalidInput when the tolerance is not positive, or as network_topology().
WeldedNetwork welded(const CurveNetwork& network, double tolerance);

}  // namespace batten
