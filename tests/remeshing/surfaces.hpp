#pragma once
#include "mesh/shapes.hpp"

#include <algorithm>

#include <Eigen/Core>

#include "batten/mesh/triangle_mesh.hpp"

// Surfaces with edges that the tests of the room share.
namespace batten::fixtures {

/// A roof: two planes that meet in a ridge along y at x = 0.46.
inline Eigen::Vector3d roof(double u, double v) {
  return {u, v, 0.15 * std::min(u / 0.46, (1 - u) / 0.54)};
}

inline TriangleMesh grid_of(int m, Eigen::Vector3d (*surface)(double, double)) {
  return fixtures::as_mesh(fixtures::grid(m, m, false, false, surface));
}

/// The surface of the unit cube, every face a grid of n × n squares, welded.
inline TriangleMesh cube(int n) {
  return box(n);
}

}  // namespace batten::fixtures
