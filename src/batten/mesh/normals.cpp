#include "batten/mesh/normals.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace batten {

namespace {

using Row = Eigen::RowVector3d;

/// Of (b − a) × (c − a), brought to unit length without loss for triangles of any size. Zero without area.
Row unit_normal(const Row& a, const Row& b, const Row& c) {
  Row u = b - a, v = c - a;
  const double length_u = u.norm(), length_v = v.norm();
  if (!(length_u > 0) || !(length_v > 0)) return Row::Zero();
  const Row n = (u / length_u).cross(v / length_v);
  const double length = n.norm();
  return length > 0 ? Row(n / length) : Row::Zero();
}

}  // namespace

Points face_normals(const Points& positions, const Triangles& triangles) {
  Points normals(triangles.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    normals.row(f) = unit_normal(positions.row(triangles(f, 0)), positions.row(triangles(f, 1)),
                                 positions.row(triangles(f, 2)));
  return normals;
}

Points vertex_normals(const Points& positions, const Triangles& triangles) {
  Points normals = Points::Zero(positions.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Row corners[3] = {positions.row(triangles(f, 0)), positions.row(triangles(f, 1)),
                            positions.row(triangles(f, 2))};
    const Row normal = unit_normal(corners[0], corners[1], corners[2]);
    for (int k = 0; k < 3; ++k) {
      const Row u = corners[(k + 1) % 3] - corners[k], v = corners[(k + 2) % 3] - corners[k];
      const double angle = std::atan2(u.cross(v).norm(), u.dot(v));  // exact also near 0 and π
      normals.row(triangles(f, k)) += angle * normal;
    }
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (length > 0) normals.row(v) /= length;
  }
  return normals;
}

double mean_normal_angle(const Points& a, const Points& b, const Triangles& triangles) {
  const Points na = face_normals(a, triangles), nb = face_normals(b, triangles);
  double sum = 0;
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Eigen::Vector3d u = na.row(f), v = nb.row(f);
    if (u.isZero(0) || v.isZero(0)) continue;
    sum += std::atan2(u.cross(v).norm(), u.dot(v));
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace batten
