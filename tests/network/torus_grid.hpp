#pragma once
#include <cmath>

#include "batten/core/units.hpp"
#include "batten/network/curve_network.hpp"

namespace batten::fixtures {

/// m circles around the tube of a torus of radii 2 and 1 and n along it, crossing in m n shared vertices,
/// with `edges` edges between two of them and no normals. The tube's radius waves by `waves` of itself.
/// Patches: m n.
inline CurveNetwork torus_grid(int m, int n, int edges, double waves) {
  CurveNetwork network;
  const int per_node = 2 * edges - 1;  // a node and the insides of the two segments that leave it
  network.positions.resize(static_cast<Eigen::Index>(m) * n * per_node, 3);
  const auto place = [&](double u, double v) {
    const double a = 2 * kPi * u / m, b = 2 * kPi * v / n;
    const double r = 1 + waves * std::sin(3 * a) * std::cos(2 * b);
    return Eigen::RowVector3d((2 + r * std::cos(b)) * std::cos(a), (2 + r * std::cos(b)) * std::sin(a),
                              r * std::sin(b));
  };
  const auto first = [&](int i, int j) { return ((i % m) * n + j % n) * per_node; };
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      const int v = first(i, j);
      network.positions.row(v) = place(i, j);
      for (int k = 1; k < edges; ++k) {
        network.positions.row(v + k) = place(i + static_cast<double>(k) / edges, j);
        network.positions.row(v + edges - 1 + k) = place(i, j + static_cast<double>(k) / edges);
      }
    }
  const auto add = [&](bool along, int fixed) {
    NetworkCurve curve;
    const int count = along ? m : n;
    for (int i = 0; i < count; ++i) {
      const int v = along ? first(i, fixed) : first(fixed, i);
      curve.vertices.push_back(v);
      for (int k = 1; k < edges; ++k) curve.vertices.push_back(along ? v + k : v + edges - 1 + k);
    }
    curve.vertices.push_back(curve.vertices.front());
    network.curves.push_back(std::move(curve));
  };
  for (int j = 0; j < n; ++j) add(true, j);
  for (int i = 0; i < m; ++i) add(false, i);
  return network;
}

/// The same curves with vertices of their own, so that crossings are not shared.
inline CurveNetwork unwelded(const CurveNetwork& network) {
  CurveNetwork strokes;
  Eigen::Index n = 0;
  for (const NetworkCurve& curve : network.curves)
    n += static_cast<Eigen::Index>(curve.vertices.size()) - (curve.closed() ? 1 : 0);
  strokes.positions.resize(n, 3);
  int next = 0;
  for (const NetworkCurve& curve : network.curves) {
    NetworkCurve stroke{curve.name, curve.boundary, {}};
    const std::size_t count = curve.vertices.size() - (curve.closed() ? 1 : 0);
    for (std::size_t k = 0; k < count; ++k) {
      strokes.positions.row(next) = network.positions.row(curve.vertices[k]);
      stroke.vertices.push_back(next++);
    }
    if (curve.closed()) stroke.vertices.push_back(stroke.vertices.front());
    strokes.curves.push_back(std::move(stroke));
  }
  return strokes;
}

}  // namespace batten::fixtures
