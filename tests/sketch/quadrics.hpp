#pragma once
#include "sketch/strokes.hpp"

// Models whose true surface is known.
namespace batten::strokes {

/// Three principal ellipses with half axes a, b, c.
inline PolylineMesh ellipsoid(double a, double b, double c) {
  PolylineMesh mesh;
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, circle(kO, a * kX, b * kY, 200)); });
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, circle(kO, a * kX, c * kZ, 200)); });
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, circle(kO, b * kY, c * kZ, 200)); });
  return mesh;
}

/// An open cylinder around z with radius 1: four circles from z = 0 to 3 and four straight lines.
inline PolylineMesh cylinder() {
  PolylineMesh mesh;
  std::vector<DrawnStroke> profiles;
  for (int k = 0; k <= 3; ++k) profiles.push_back(circle(k * kZ, kX, kY, 200));
  const auto line = [](const Eigen::Vector3d& foot) {
    return DrawnStroke{polygon({foot, foot + 3 * kZ}, 60), false};
  };
  edit(mesh, [&](PolylineMesh& m) { return skin_profiles(m, profiles, {line(kX), line(-kX)}); });
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, line(kY)); });
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, line(-kY)); });
  return mesh;
}

/// A torus around z with radii 2 and 1: eight circles around the tube, and the outer, inner, upper and lower
/// circles along it.
inline PolylineMesh torus() {
  PolylineMesh mesh;
  constexpr int kProfiles = 8;
  std::vector<DrawnStroke> profiles;
  for (int k = 0; k < kProfiles; ++k) {
    const double turn = 2 * kPi * k / kProfiles;
    const Eigen::Vector3d out = std::cos(turn) * kX + std::sin(turn) * kY;
    profiles.push_back(circle(2 * out, out, kZ, 200));
  }
  const auto along = [](double radius, double from, double to) {
    return DrawnStroke{arc(kO, radius * kX, radius * kY, from, to, 200), false};
  };
  const double last = 2 * kPi * (kProfiles - 1) / kProfiles;
  edit(mesh, [&](PolylineMesh& m) {
    return skin_profiles(m, profiles, {along(3, 0, last), along(1, 0, last)});
  });
  edit(mesh, [&](PolylineMesh& m) {
    return glue_borders(m, along(3, last, 2 * kPi), along(1, last, 2 * kPi), std::nullopt);
  });
  for (const double height : {1.0, -1.0})
    edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, circle(height * kZ, 2 * kX, 2 * kY, 200)); });
  return mesh;
}

}  // namespace batten::strokes
