#include "batten/mesh/areas.hpp"

#include <Eigen/Geometry>

namespace batten {

namespace {

using Row = Eigen::RowVector3d;

}  // namespace

Eigen::VectorXd face_areas(const Points& positions, const Triangles& triangles) {
  Eigen::VectorXd areas(triangles.rows());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Row a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
              c = positions.row(triangles(f, 2));
    areas(f) = 0.5 * (b - a).cross(c - a).norm();
  }
  return areas;
}

double surface_area(const Points& positions, const Triangles& triangles) {
  return face_areas(positions, triangles).sum();
}

double enclosed_volume(const Points& positions, const Triangles& triangles) {
  if (positions.rows() == 0) return 0;
  const Row origin = 0.5 * (positions.colwise().minCoeff() + positions.colwise().maxCoeff());
  double sum = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Row a = positions.row(triangles(f, 0)) - origin, b = positions.row(triangles(f, 1)) - origin,
              c = positions.row(triangles(f, 2)) - origin;
    sum += a.dot(b.cross(c));
  }
  return sum / 6;
}

}  // namespace batten
