#pragma once
#include <cmath>
#include <functional>
#include <initializer_list>
#include <vector>

#include "batten/core/units.hpp"
#include "batten/sketch/tools.hpp"

// Strokes that many tests draw.
namespace batten::strokes {

/// c + r (cos t a + sin t b) for t from t0 to t1.
inline Points arc(const Eigen::Vector3d& centre, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  double t0, double t1, int n = 100) {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    const double t = t0 + (t1 - t0) * i / n;
    points.row(i) = (centre + std::cos(t) * a + std::sin(t) * b).transpose();
  }
  return points;
}

/// A closed circle around a centre, spanned by two radii.
inline DrawnStroke circle(const Eigen::Vector3d& centre, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                          int n = 100) {
  return {arc(centre, a, b, 0, 2 * kPi * (n - 1) / n, n - 1), true};
}

/// A polygon, `n` points on each side.
inline Points polygon(std::initializer_list<Eigen::Vector3d> corners, int n = 20) {
  const std::vector<Eigen::Vector3d> all(corners);
  Points points(static_cast<Eigen::Index>((all.size() - 1) * static_cast<size_t>(n)) + 1, 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto k = static_cast<size_t>(i) / static_cast<size_t>(n);
    const double t = static_cast<double>(i % n) / n;
    points.row(i) =
        (k + 1 < all.size() ? ((1 - t) * all[k] + t * all[k + 1]).eval() : all.back()).transpose();
  }
  return points;
}

/// Runs a tool as a document does: whole or not at all.
inline EditReport edit(PolylineMesh& mesh, const std::function<EditReport(PolylineMesh&)>& tool) {
  mesh.begin();
  try {
    EditReport report = tool(mesh);
    mesh.commit();
    return report;
  } catch (...) {
    mesh.roll_back();
    throw;
  }
}

inline const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(),
                             kZ = Eigen::Vector3d::UnitZ(), kO = Eigen::Vector3d::Zero();

/// The model of these strokes, drawn one after the other.
inline PolylineMesh model(const std::vector<std::pair<DrawnStroke, InsertOptions>>& drawn) {
  PolylineMesh mesh;
  for (const auto& [stroke, options] : drawn)
    edit(mesh, [&, &s = stroke, &o = options](PolylineMesh& m) { return insert_curve(m, s, o); });
  return mesh;
}

/// Three orthogonal great circles of the unit sphere (H fig. 7.7).
inline PolylineMesh three_great_circles() {
  return model({{circle(kO, kX, kY, 200), {}}, {circle(kO, kX, kZ, 200), {}}, {circle(kO, kY, kZ, 200), {}}});
}

}  // namespace batten::strokes
