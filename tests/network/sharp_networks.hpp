#pragma once
#include "network/sample_networks.hpp"

#include <cmath>

namespace batten::samples {

/// The edges of a cube of side 2, n steps each; normals are means of those of the faces around.
inline CurveNetwork cube_edges(int n, bool sharp) {
  NetworkBuilder builder;
  const auto normal = [](const Eigen::Vector3d& p) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      if (std::abs(p[k]) > 1 - 1e-9) sum[k] = p[k];
    return sum;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const double u : {-1.0, 1.0})
      for (const double w : {-1.0, 1.0})
        builder.curve(
            n, false,
            [=](double t) {
              Eigen::Vector3d p = Eigen::Vector3d::Zero();
              p[axis] = 2 * t - 1;
              p[(axis + 1) % 3] = u;
              p[(axis + 2) % 3] = w;
              return p;
            },
            normal);
  CurveNetwork network = builder.build();
  for (NetworkCurve& curve : network.curves) curve.sharp = sharp;
  return network;
}

/// A cylinder of radius 1 between z = 0 and z = 2 with flat ends: its two rims, curves 0 and 1, and `lines`
/// straight lines.
inline CurveNetwork capped_cylinder(int lines, int n, bool sharp) {
  NetworkBuilder builder;
  for (const double z : {0.0, 2.0})
    builder.curve(
        lines * n, false,
        [=](double t) { return Eigen::Vector3d(std::cos(2 * kPi * t), std::sin(2 * kPi * t), z); },
        [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), p.y(), p.z() - 1); });
  for (int k = 0; k < lines; ++k)
    builder.curve(
        n, false,
        [=](double t) {
          const double angle = 2 * kPi * k / lines;
          return Eigen::Vector3d(std::cos(angle), std::sin(angle), 2 * t);
        },
        [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), p.y(), 0); });
  CurveNetwork network = builder.build();
  network.curves[0].sharp = network.curves[1].sharp = sharp;
  return network;
}

/// The body common to the unit balls around (0, 0, 0.6) and (0, 0, −0.6): its rim, curve 0, and two
/// meridians.
inline CurveNetwork lens(int n, bool sharp) {
  NetworkBuilder builder;
  builder.curve(
      4 * n, false,
      [](double t) { return Eigen::Vector3d(0.8 * std::cos(2 * kPi * t), 0.8 * std::sin(2 * kPi * t), 0); },
      [](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p; });
  for (const double angle : {0.0, 0.5 * kPi})
    for (const double side : {1.0, -1.0})
      builder.curve(
          2 * n, false,
          [=](double t) {
            const double at = std::asin(0.8) * (2 * t - 1);
            return Eigen::Vector3d(std::sin(at) * std::cos(angle), std::sin(at) * std::sin(angle),
                                   side * (std::cos(at) - 0.6));
          },
          [=](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p + Eigen::Vector3d(0, 0, side * 0.6); });
  CurveNetwork network = builder.build();
  network.curves[0].sharp = sharp;
  return network;
}

/// The normal of the lens nearest to a point of it.
inline Eigen::Vector3d lens_normal(const Eigen::Vector3d& p, bool upper) {
  return (p + Eigen::Vector3d(0, 0, upper ? 0.6 : -0.6)).normalized();
}

}  // namespace batten::samples
