#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include <Eigen/Dense>

#include "batten/core/units.hpp"
#include "batten/network/curve_network.hpp"

namespace batten::samples {

/// Collects curves given by points and normals; points within 1e-9 of each other become one vertex.
class NetworkBuilder {
 public:
  int vertex(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    const std::array<long long, 3> key = {std::llround(p.x() * 1e8), std::llround(p.y() * 1e8),
                                          std::llround(p.z() * 1e8)};
    const auto [place, is_new] = index_.emplace(key, static_cast<int>(points_.size()));
    if (is_new) {
      points_.push_back(p);
      normals_.push_back(normal.normalized());
    }
    return place->second;
  }
  /// A curve t ↦ p(t), 0 ≤ t ≤ 1, in n steps.
  void curve(int n, bool boundary, const std::function<Eigen::Vector3d(double)>& p,
             const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& normal) {
    NetworkCurve c;
    c.boundary = boundary;
    for (int i = 0; i <= n; ++i) {
      const Eigen::Vector3d x = p(static_cast<double>(i) / n);
      c.vertices.push_back(vertex(x, normal(x)));
    }
    network_.curves.push_back(c);
  }
  CurveNetwork build() {
    network_.positions.resize(static_cast<Eigen::Index>(points_.size()), 3);
    network_.normals.resize(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      network_.positions.row(static_cast<Eigen::Index>(i)) = points_[i];
      network_.normals.row(static_cast<Eigen::Index>(i)) = normals_[i];
    }
    return network_;
  }

 private:
  CurveNetwork network_;
  std::map<std::array<long long, 3>, int> index_;
  std::vector<Eigen::Vector3d> points_, normals_;
};

/// Three great circles of the unit sphere, 4·n vertices each: eight octants.
inline CurveNetwork octahedral_sphere(int n, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero(),
                                      double radius = 1) {
  NetworkBuilder builder;
  for (int axis = 0; axis < 3; ++axis)
    builder.curve(
        4 * n, false,
        [&](double t) {
          Eigen::Vector3d p = Eigen::Vector3d::Zero();
          // Quarter points exactly on the axes, so that the circles share them.
          p[(axis + 1) % 3] = radius * std::cos(2 * kPi * t);
          p[(axis + 2) % 3] = radius * std::sin(2 * kPi * t);
          return Eigen::Vector3d(p + centre);
        },
        [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(x - centre); });
  return builder.build();
}

/// The square [−1, 1]² with both middle lines on the graph of f: four patches. The border is tagged if
/// wanted.
inline CurveNetwork square_graph(int n, bool tagged, const std::function<double(double, double)>& f) {
  NetworkBuilder builder;
  const auto lift = [&](double x, double y) { return Eigen::Vector3d(x, y, f(x, y)); };
  const auto normal = [&](const Eigen::Vector3d& p) {
    const double e = 1e-5;
    return Eigen::Vector3d(-(f(p.x() + e, p.y()) - f(p.x() - e, p.y())) / (2 * e),
                           -(f(p.x(), p.y() + e) - f(p.x(), p.y() - e)) / (2 * e), 1);
  };
  for (const double s : {-1.0, 1.0}) {
    builder.curve(
        2 * n, tagged, [&](double t) { return lift(2 * t - 1, s); }, normal);
    builder.curve(
        2 * n, tagged, [&](double t) { return lift(s, 2 * t - 1); }, normal);
  }
  builder.curve(
      2 * n, false, [&](double t) { return lift(2 * t - 1, 0); }, normal);
  builder.curve(
      2 * n, false, [&](double t) { return lift(0, 2 * t - 1); }, normal);
  return builder.build();
}

/// A circle about the z axis with its normals turned by `tilt` from the radius towards z.
inline void add_circle(NetworkBuilder& builder, int n, double radius, double z, double tilt, bool boundary) {
  builder.curve(
      n, boundary,
      [&](double t) {
        return Eigen::Vector3d(radius * std::cos(2 * kPi * t), radius * std::sin(2 * kPi * t), z);
      },
      [&](const Eigen::Vector3d& x) {
        return Eigen::Vector3d(std::cos(tilt) * x.x() / radius, std::cos(tilt) * x.y() / radius,
                               std::sin(tilt));
      });
}

/// Its curves alone, as somebody draws them.
inline CurveNetwork without_normals(CurveNetwork network) {
  network.normals.resize(0, 3);
  return network;
}

}  // namespace batten::samples
