#pragma once
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/network/curve_network.hpp"

namespace batten::test {

constexpr double kTurn = 2 * kPi;

/// A stroke of n + 1 points, without normals; strokes share no vertices.
inline void add_stroke(CurveNetwork& strokes, int n, const std::function<Eigen::Vector3d(double)>& at) {
  const auto first = static_cast<int>(strokes.positions.rows());
  strokes.positions.conservativeResize(first + n + 1, 3);
  NetworkCurve curve;
  for (int k = 0; k <= n; ++k) {
    strokes.positions.row(first + k) = at(static_cast<double>(k) / n);
    curve.vertices.push_back(first + k);
  }
  strokes.curves.push_back(curve);
}

/// Arcs of the unit sphere that miss each other by `miss`: three great circles, each cut into `arcs` pieces
/// with gaps of `gap` of their length between them.
inline CurveNetwork sphere_strokes(int arcs = 3, double gap = 0.15, double miss = 0.005) {
  CurveNetwork strokes;
  Random random(5);
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < arcs; ++k) {
      const Eigen::Vector3d off = miss * random.direction();
      add_stroke(strokes, 40, [&](double t) {
        const double a = kTurn * (k + (1 - gap) * t + 0.11 * axis) / arcs;
        Eigen::Vector3d x = Eigen::Vector3d::Zero();
        x[(axis + 1) % 3] = std::cos(a);
        x[(axis + 2) % 3] = std::sin(a);
        return Eigen::Vector3d(x + off);
      });
    }
  return strokes;
}

/// Circles of a torus around z, of radii 1 and 0.4, that do not touch each other: meridians and two
/// parallels.
inline CurveNetwork torus_strokes(int meridians = 6) {
  CurveNetwork strokes;
  const auto torus = [](double u, double v) {
    const double r = 1 + 0.4 * std::cos(v);
    return Eigen::Vector3d(r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v));
  };
  for (int k = 0; k < meridians; ++k)
    add_stroke(strokes, 40, [&](double t) { return torus(kTurn * k / meridians, kTurn * (0.05 + 0.9 * t)); });
  for (const double v : {0.0, kTurn / 2})
    add_stroke(strokes, 80, [&](double t) { return torus(kTurn * (0.02 + 0.95 * t), v); });
  return strokes;
}

}  // namespace batten::test
