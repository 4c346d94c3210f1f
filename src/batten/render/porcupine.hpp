#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/network/curve_network.hpp"

namespace batten {

/// The quills of one curve of a porcupine plot (S fig. 3.12).
struct Quills {
  int curve = -1;
  Points roots;       ///< on the curve
  Points directions;  ///< unit: the surface normal, or away from the centre of curvature without normals
  Eigen::VectorXd curvature;  ///< along `directions`, 1/length; positive where the curve bends away from it
};

/// Curvature along every curve of a network, at each vertex with two neighbours (the ends take that of the
/// next vertex): the circle through three points, projected on the surface normal where there are normals. On
/// a sphere of radius r with outward normals every value is 1/r for great circles.
/// @throws InvalidInput when an index is out of range.
std::vector<Quills> porcupine(const CurveNetwork& network);

}  // namespace batten
