#include "batten/render/porcupine.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

using Eigen::Vector3d;

namespace {

/// Curvature vector (towards the centre, length 1/r) of the circle through three points; zero on a line.
Vector3d curvature_vector(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d u = b - a, v = c - b, w = c - a;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  if (!(lu > 0) || !(lv > 0) || !(lw > 0)) return Vector3d::Zero();
  const Vector3d turn = u.cross(v);  // |turn| = lu lv sin; curvature = 2 |turn| / (lu lv lw)
  const Vector3d across = turn.cross(lv / lu * u + lu / lv * v);
  const double length = across.norm();
  if (!(length > 0)) return Vector3d::Zero();
  return 2 * turn.norm() / (lu * lv * lw) * across / length;
}

}  // namespace

std::vector<Quills> porcupine(const CurveNetwork& network) {
  std::vector<Quills> plot;
  for (std::size_t c = 0; c < network.curves.size(); ++c) {
    const NetworkCurve& curve = network.curves[c];
    for (const int v : curve.vertices)
      if (v < 0 || v >= network.positions.rows())
        throw InvalidInput(concat("curve ", c, " names vertex ", v, ", which does not exist"));
    const auto n = static_cast<Eigen::Index>(curve.vertices.size());
    if (n < 3) continue;
    const auto at = [&](Eigen::Index i) -> Vector3d { return network.positions.row(curve.vertices[i]); };
    Quills quills;
    quills.curve = static_cast<int>(c);
    quills.roots.resize(n, 3);
    quills.directions.resize(n, 3);
    quills.curvature.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      quills.roots.row(i) = at(i);
      Vector3d bend;
      if (i > 0 && i + 1 < n)
        bend = curvature_vector(at(i - 1), at(i), at(i + 1));
      else if (curve.closed())
        bend = curvature_vector(at(n - 2), at(0), at(1));
      else
        bend = i == 0 ? curvature_vector(at(0), at(1), at(2))
                      : curvature_vector(at(n - 3), at(n - 2), at(n - 1));
      const Vector3d normal =
          network.has_normals() ? Vector3d(network.normals.row(curve.vertices[i]))
                                : Vector3d(bend.norm() > 0 ? Vector3d(-bend.normalized()) : Vector3d::Zero());
      quills.directions.row(i) = normal;
      quills.curvature[i] = -bend.dot(normal);
    }
    plot.push_back(std::move(quills));
  }
  return plot;
}

}  // namespace batten
