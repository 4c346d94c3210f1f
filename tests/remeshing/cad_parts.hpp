#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "batten/mesh/triangle_mesh.hpp"

// Parts as CAD programs export them: few vertices, all of them on sharp edges or on the lines between facets,
// and long thin triangles between them.
namespace batten::fixtures {

using Loop = std::vector<Eigen::Vector3d>;

/// Puts a solid together from flat faces with holes; points at the same place become one vertex.
class PartBuilder {
 public:
  /// A flat face: counter-clockwise around its outside as seen from outside of the solid, holes the other
  /// way. Cut into triangles by ear clipping, without vertices of its own.
  void add_face(const Loop& outer, const std::vector<Loop>& holes = {}) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < outer.size(); ++i) normal += outer[i].cross(outer[(i + 1) % outer.size()]);
    normal.normalize();
    const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    const auto flat = [&](const Eigen::Vector3d& p) { return Eigen::Vector2d(p.dot(u), p.dot(v)); };
    Loop loop = outer;
    std::vector<Loop> left = holes;
    // Holes are joined by a bridge from their rightmost point, the rightmost hole first.
    const auto rightmost = [&](const Loop& hole) {
      return std::max_element(hole.begin(), hole.end(),
                              [&](const auto& a, const auto& b) { return flat(a).x() < flat(b).x(); });
    };
    std::sort(left.begin(), left.end(), [&](const Loop& a, const Loop& b) {
      return flat(*rightmost(a)).x() > flat(*rightmost(b)).x();
    });
    for (Loop& hole : left) {
      std::rotate(hole.begin(), hole.begin() + (rightmost(hole) - hole.begin()), hole.end());
      std::size_t best = 0;
      double nearest = 1e300;
      for (std::size_t i = 0; i < loop.size(); ++i)
        if ((loop[i] - hole[0]).norm() < nearest && sees(loop, left, hole[0], loop[i], flat)) {
          nearest = (loop[i] - hole[0]).norm();
          best = i;
        }
      Loop joined(loop.begin(), loop.begin() + static_cast<long>(best) + 1);
      joined.insert(joined.end(), hole.begin(), hole.end());
      joined.push_back(hole[0]);
      joined.insert(joined.end(), loop.begin() + static_cast<long>(best), loop.end());
      loop = std::move(joined);
    }
    clip_ears(loop, flat);
  }
  /// Strips between two loops with as many points: from `lower` up to `upper` to the right of the sense of
  /// the loops as seen from outside.
  void add_wall(const Loop& lower, const Loop& upper) {
    for (std::size_t i = 0; i < lower.size(); ++i) {
      const std::size_t j = (i + 1) % lower.size();
      add_triangle(lower[i], lower[j], upper[j]);
      add_triangle(lower[i], upper[j], upper[i]);
    }
  }
  /// Triangles from one point to the sides of a loop.
  void add_fan(const Eigen::Vector3d& middle, const Loop& loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) add_triangle(middle, loop[i], loop[(i + 1) % loop.size()]);
  }

  TriangleMesh mesh() const {
    TriangleMesh result;
    result.positions.resize(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      result.positions.row(static_cast<Eigen::Index>(v)) = points_[v];
    result.triangles.resize(static_cast<Eigen::Index>(faces_.size()), 3);
    for (std::size_t f = 0; f < faces_.size(); ++f)
      result.triangles.row(static_cast<Eigen::Index>(f)) << faces_[f][0], faces_[f][1], faces_[f][2];
    return result;
  }

 private:
  static double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  }
  template <typename Flat>
  static bool sees(const Loop& loop, const std::vector<Loop>& holes, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to, const Flat& flat) {
    const Eigen::Vector2d a = flat(from), b = flat(to);
    const auto crosses = [&](const Loop& sides) {
      for (std::size_t i = 0; i < sides.size(); ++i) {
        const Eigen::Vector2d p = flat(sides[i]), q = flat(sides[(i + 1) % sides.size()]);
        if ((p - a).norm() < 1e-9 || (q - a).norm() < 1e-9 || (p - b).norm() < 1e-9 || (q - b).norm() < 1e-9)
          continue;
        if (turn(a, b, p) * turn(a, b, q) <= 0 && turn(p, q, a) * turn(p, q, b) <= 0) return true;
      }
      return false;
    };
    if (crosses(loop)) return false;
    return std::none_of(holes.begin(), holes.end(), crosses);
  }
  template <typename Flat>
  void clip_ears(Loop loop, const Flat& flat) {
    while (loop.size() > 3) {
      std::size_t ear = loop.size();
      for (std::size_t i = 0; i < loop.size() && ear == loop.size(); ++i) {
        const Eigen::Vector2d a = flat(loop[(i + loop.size() - 1) % loop.size()]), b = flat(loop[i]),
                              c = flat(loop[(i + 1) % loop.size()]);
        if (!(turn(a, b, c) > 1e-12)) continue;
        bool empty = true;
        for (const Eigen::Vector3d& other : loop) {
          const Eigen::Vector2d p = flat(other);
          if ((p - a).norm() < 1e-9 || (p - b).norm() < 1e-9 || (p - c).norm() < 1e-9) continue;
          empty = empty && !(turn(a, b, p) > -1e-12 && turn(b, c, p) > -1e-12 && turn(c, a, p) > -1e-12);
        }
        if (empty) ear = i;
      }
      if (ear == loop.size()) return;  // seen by the test of the volume
      add_triangle(loop[(ear + loop.size() - 1) % loop.size()], loop[ear], loop[(ear + 1) % loop.size()]);
      loop.erase(loop.begin() + static_cast<long>(ear));
    }
    add_triangle(loop[0], loop[1], loop[2]);
  }
  void add_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    faces_.push_back({number(a), number(b), number(c)});
  }
  int number(const Eigen::Vector3d& p) {
    const std::array<long, 3> key{std::lround(p.x() * 1e8), std::lround(p.y() * 1e8),
                                  std::lround(p.z() * 1e8)};
    const auto [at, is_new] = numbers_.emplace(key, static_cast<int>(points_.size()));
    if (is_new) points_.push_back(p);
    return at->second;
  }

  std::map<std::array<long, 3>, int> numbers_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::array<int, 3>> faces_;
};

/// A regular polygon about the z axis through (x, y, z), counter-clockwise as seen from above.
inline Loop ring(int sides, double radius, double z, double x = 0, double y = 0, double phase = 0) {
  Loop loop;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides + phase;
    loop.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle), z);
  }
  return loop;
}
inline Loop reversed(Loop loop) {
  std::reverse(loop.begin(), loop.end());
  return loop;
}
inline Loop at_height(Loop loop, double z) {
  for (Eigen::Vector3d& p : loop) p.z() = z;
  return loop;
}

/// A rod along z, capped by fans: from a vertex of the ring or from a middle of their own.
inline TriangleMesh rod(int sides, double radius, double length, bool middles = false) {
  PartBuilder part;
  const Loop low = ring(sides, radius, 0), high = ring(sides, radius, length);
  part.add_wall(low, high);
  if (middles) {
    part.add_fan({0, 0, 0}, reversed(low));
    part.add_fan({0, 0, length}, high);
  } else {
    part.add_face(reversed(low));
    part.add_face(high);
  }
  return part.mesh();
}

/// A flat plate of any outline (counter-clockwise) with holes (counter-clockwise too), from z = 0 up.
inline TriangleMesh plate(const Loop& outline, const std::vector<Loop>& holes, double thickness) {
  PartBuilder part;
  std::vector<Loop> above, below;
  part.add_wall(at_height(outline, 0), at_height(outline, thickness));
  for (const Loop& hole : holes) {
    part.add_wall(reversed(at_height(hole, 0)), reversed(at_height(hole, thickness)));
    above.push_back(reversed(at_height(hole, thickness)));
    below.push_back(at_height(hole, 0));
  }
  part.add_face(at_height(outline, thickness), above);
  part.add_face(reversed(at_height(outline, 0)), below);
  return part.mesh();
}

inline Loop rectangle(double x0, double y0, double x1, double y1, double z = 0) {
  return {{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
}

/// A shaft of cylinders about z: each a radius and a length.
inline TriangleMesh stepped_shaft(int sides, const std::vector<std::array<double, 2>>& steps) {
  PartBuilder part;
  double z = 0;
  part.add_face(reversed(ring(sides, steps.front()[0], 0)));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Loop low = ring(sides, steps[i][0], z), high = ring(sides, steps[i][0], z + steps[i][1]);
    part.add_wall(low, high);
    z += steps[i][1];
    if (i + 1 == steps.size()) {
      part.add_face(high);
    } else {
      const Loop next = ring(sides, steps[i + 1][0], z);
      if (steps[i + 1][0] < steps[i][0])
        part.add_face(high, {reversed(next)});
      else
        part.add_face(reversed(next), {high});
    }
  }
  return part.mesh();
}

/// A flange: a disc with a bore and bolt holes, and a collar around the bore.
inline TriangleMesh flange(int sides, double radius, double bore, int bolts, double bolt_radius,
                           int bolt_sides, double thickness, double collar_radius, double collar) {
  PartBuilder part;
  const Loop rim = ring(sides, radius, 0);
  const Loop inner = ring(sides, bore, 0), neck = ring(sides, collar_radius, 0);
  std::vector<Loop> below{inner}, above{reversed(at_height(neck, thickness))};
  for (int i = 0; i < bolts; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.3) / bolts, r = 0.5 * (radius + collar_radius);
    const Loop hole = ring(bolt_sides, bolt_radius, 0, r * std::cos(angle), r * std::sin(angle), 0.1);
    below.push_back(hole);
    above.push_back(reversed(at_height(hole, thickness)));
    part.add_wall(reversed(hole), reversed(at_height(hole, thickness)));
  }
  part.add_wall(rim, at_height(rim, thickness));
  part.add_face(reversed(rim), below);
  part.add_face(at_height(rim, thickness), above);
  const double top = thickness + collar;
  part.add_wall(at_height(neck, thickness), at_height(neck, top));
  part.add_face(at_height(neck, top), {reversed(at_height(inner, top))});
  part.add_wall(reversed(inner), reversed(at_height(inner, top)));
  return part.mesh();
}

/// An angle bracket: two legs along x and z of the given lengths, `width` along y, with a hole of `sides`
/// sides in each.
inline TriangleMesh bracket(double leg_x, double leg_z, double width, double thickness, int sides,
                            double hole_radius) {
  PartBuilder part;
  const double t = thickness;
  const auto turned = [](const Loop& loop) {  // x y 0 → 0 y x: a loop that was seen from above is from −x
    Loop result;
    for (const Eigen::Vector3d& p : loop) result.emplace_back(p.z(), p.y(), p.x());
    return result;
  };
  const Loop hole_x = ring(sides, hole_radius, 0, 0.5 * (leg_x + t), 0.5 * width);
  const Loop hole_z = ring(sides, hole_radius, 0, 0.5 * (leg_z + t), 0.5 * width);
  const auto at = [&](double x, double y, double z) { return Eigen::Vector3d(x, y, z); };
  // The horizontal leg, below and above.
  part.add_face(reversed(rectangle(0, 0, leg_x, width)), {hole_x});
  part.add_face(rectangle(t, 0, leg_x, width, t), {reversed(at_height(hole_x, t))});
  part.add_wall(reversed(hole_x), reversed(at_height(hole_x, t)));
  // The upright leg, outside (x = 0) and inside (x = t).
  part.add_face(turned(rectangle(0, 0, leg_z, width)), {turned(reversed(hole_z))});
  part.add_face(turned(reversed(rectangle(t, 0, leg_z, width, t))), {turned(at_height(hole_z, t))});
  part.add_wall(turned(hole_z), turned(at_height(hole_z, t)));
  // Ends and sides.
  part.add_face({at(leg_x, 0, 0), at(leg_x, width, 0), at(leg_x, width, t), at(leg_x, 0, t)});
  part.add_face({at(0, 0, leg_z), at(t, 0, leg_z), at(t, width, leg_z), at(0, width, leg_z)});
  part.add_face(
      {at(0, 0, 0), at(leg_x, 0, 0), at(leg_x, 0, t), at(t, 0, t), at(t, 0, leg_z), at(0, 0, leg_z)});
  part.add_face({at(0, width, 0), at(0, width, leg_z), at(t, width, leg_z), at(t, width, t),
                 at(leg_x, width, t), at(leg_x, width, 0)});
  return part.mesh();
}

}  // namespace batten::fixtures
