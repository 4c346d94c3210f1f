#pragma once
#include <cmath>
#include <map>

#include "batten/core/units.hpp"
#include "batten/network/curve_network.hpp"

namespace batten::fixtures {

/// The three great circles in the coordinate planes of the sphere of radius r, 4 m samples each, closed
/// curves that share their six nodes; normals are the directions of the points.
inline CurveNetwork three_great_circles(int m, double r = 1) {
  CurveNetwork network;
  network.positions.resize(6 + 3 * 4 * (m - 1), 3);
  int next = 6;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    NetworkCurve curve;
    for (int i = 0; i < 4 * m; ++i) {
      const double angle = kPi * i / (2 * m);
      Eigen::RowVector3d p = Eigen::RowVector3d::Zero();
      p(u) = std::cos(angle);
      p(v) = std::sin(angle);
      int vertex = next;
      if (i % m == 0) {  // ±u, ±v: nodes 0–5 are +x −x +y −y +z −z
        const int quarter = i / m;
        const int along = quarter % 2 == 0 ? u : v;
        vertex = 2 * along + (quarter >= 2 ? 1 : 0);
        p = (quarter >= 2 ? -1 : 1) * Eigen::RowVector3d::Unit(along);
      } else {
        ++next;
      }
      network.positions.row(vertex) = r * p;
      curve.vertices.push_back(vertex);
    }
    curve.vertices.push_back(curve.vertices.front());
    network.curves.push_back(curve);
  }
  network.normals = network.positions / r;
  return network;
}

/// Appends a polyline of its own vertices; returns the index of the curve.
inline int add_polyline(CurveNetwork& network, const Points& points, bool boundary = false) {
  const auto first = static_cast<int>(network.positions.rows());
  network.positions.conservativeResize(first + points.rows(), 3);
  network.positions.bottomRows(points.rows()) = points;
  NetworkCurve curve;
  curve.boundary = boundary;
  for (int i = 0; i < points.rows(); ++i) curve.vertices.push_back(first + i);
  network.curves.push_back(curve);
  return static_cast<int>(network.curves.size()) - 1;
}

/// n points from a to b.
inline Points line(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, int n) {
  Points points(n, 3);
  for (int i = 0; i < n; ++i) points.row(i) = a + (b - a) * i / (n - 1);
  return points;
}

}  // namespace batten::fixtures
