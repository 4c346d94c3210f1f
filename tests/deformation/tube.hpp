#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/arrays.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"

// A tube with bumps and the same bumps on the tube twisted and bent by formula.
namespace batten::fixtures {

using Eigen::Vector3d;

/// A tube around the z axis with bumps, open at both ends, and the rows of rings at each end.
struct Tube {
  Points positions;
  Triangles triangles;
  std::vector<int> ends;
  double first = 0, last = 0;  ///< the free part in z
};

/// Radius 1, bumps of the given height, 8 around and along.
inline Tube bumpy_tube(int around, double length, double bump, double held) {
  const double step = 2 * kPi / around;
  const int rings = static_cast<int>(std::lround(length / (step * std::sqrt(3.0) / 2)));
  Tube tube;
  tube.first = held * length;
  tube.last = (1 - held) * length;
  tube.positions.resize((rings + 1) * around, 3);
  tube.triangles.resize(2 * rings * around, 3);
  Eigen::Index face = 0;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double z = length * i / rings, angle = step * (j + 0.5 * (i % 2));
      const double r = 1 + bump * std::sin(8 * angle) * std::sin(8 * z);
      const int v = i * around + j;
      tube.positions.row(v) << r * std::cos(angle), r * std::sin(angle), z;
      if (z <= tube.first + 1e-9 || z >= tube.last - 1e-9) tube.ends.push_back(v);
      if (i == rings) continue;
      const int b = i * around + (j + 1) % around, c = v + around, d = b + around;
      if (i % 2 == 0) {
        tube.triangles.row(face++) << v, b, c;
        tube.triangles.row(face++) << b, d, c;
      } else {
        tube.triangles.row(face++) << v, d, c;
        tube.triangles.row(face++) << v, b, d;
      }
    }
  return tube;
}

inline Points rows_of(const Points& points, const std::vector<int>& rows) {
  Points part(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) part.row(static_cast<Eigen::Index>(i)) = points.row(rows[i]);
  return part;
}

/// The tube with its free part turned about its axis, uniformly, by `angle` in all.
inline Points twisted(const Tube& tube, double angle) {
  Points result = tube.positions;
  for (Eigen::Index v = 0; v < result.rows(); ++v) {
    const double s = std::clamp((result(v, 2) - tube.first) / (tube.last - tube.first), 0.0, 1.0);
    result.row(v) = tube.positions.row(v) *
                    Eigen::AngleAxisd(s * angle, Vector3d::UnitZ()).toRotationMatrix().transpose();
  }
  return result;
}

/// The tube with the axis of its free part bent to an arc of `angle`, of the same length.
inline Points bent(const Tube& tube, double angle) {
  Points result = tube.positions;
  const double length = tube.last - tube.first, radius = length / angle;
  for (Eigen::Index v = 0; v < result.rows(); ++v) {
    const Vector3d p = tube.positions.row(v);
    const double s = std::clamp((p.z() - tube.first) / length, 0.0, 1.0), a = s * angle;
    const double beyond = p.z() - (tube.first + s * length);
    const Vector3d centre(radius * (1 - std::cos(a)), 0, tube.first + radius * std::sin(a));
    const Vector3d tangent(std::sin(a), 0, std::cos(a)), inward(std::cos(a), 0, -std::sin(a));
    result.row(v) = centre + beyond * tangent + p.x() * inward + p.y() * Vector3d::UnitY();
  }
  return result;
}

inline double mean_normal_angle_deg(const Points& a, const Points& b, const Triangles& triangles) {
  const Points n = vertex_normals(a, triangles), m = vertex_normals(b, triangles);
  double sum = 0;
  for (Eigen::Index v = 0; v < n.rows(); ++v) {
    const Vector3d x = n.row(v), y = m.row(v);
    sum += degrees(std::atan2(x.cross(y).norm(), x.dot(y)));
  }
  return sum / static_cast<double>(n.rows());
}

inline int flipped_faces(const Points& result, const Points& truth, const Triangles& triangles) {
  const Points n = face_normals(result, triangles), m = face_normals(truth, triangles);
  return static_cast<int>(((n.array() * m.array()).rowwise().sum() <= 0).count());
}

}  // namespace batten::fixtures
