#include "batten/operators/shape_operator.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

/// A sheet of n × n cells over [0, 1]², mapped to space, and its exact normals.
template <typename Point, typename Normal>
FaceCurvatures curvatures_of(int n, const Point& point, const Normal& normal, Triangles& triangles) {
  Points positions((n + 1) * (n + 1), 3), normals((n + 1) * (n + 1), 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
      positions.row(i * (n + 1) + j) = point(u, v).transpose();
      normals.row(i * (n + 1) + j) = normal(u, v).transpose();
    }
  triangles.resize(2 * n * n, 3);
  int t = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int p = i * (n + 1) + j, q = p + n + 1;
      triangles.row(t++) << p, q, q + 1;
      triangles.row(t++) << p, q + 1, p + 1;
    }
  return face_curvatures(positions, triangles, normals);
}

// A cylinder of radius 2 bends by 1/2 across its axis z and not along it, from normals that are exact at the
// corners: the first direction is tangential, the second the axis.
TEST(FaceCurvatures, OfACylinderAreThoseOfItsCircle) {
  Triangles triangles;
  const auto normal = [](double u, double) { return Eigen::Vector3d(std::cos(u), std::sin(u), 0); };
  const FaceCurvatures found = curvatures_of(
      32, [&](double u, double v) { return Eigen::Vector3d(2 * normal(u, v) + Eigen::Vector3d(0, 0, v)); },
      normal, triangles);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    EXPECT_NEAR(found.first[f], 0.5, 1e-3);
    EXPECT_NEAR(found.second[f], 0, 1e-3);
    EXPECT_NEAR(std::abs(found.second_direction(f, 2)), 1, 1e-3);
    EXPECT_NEAR(found.first_direction.row(f).dot(found.second_direction.row(f)), 0, 1e-12);
  }
}

// On a sphere ΔN = e/R holds exactly for every side, whatever the triangle.
TEST(FaceCurvatures, OfASphereAreExact) {
  Triangles triangles;
  const auto normal = [](double u, double v) {
    const double a = 0.5 + u, b = 2 * v;
    return Eigen::Vector3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
  };
  const FaceCurvatures found = curvatures_of(
      6, [&](double u, double v) { return Eigen::Vector3d(3 * normal(u, v)); }, normal, triangles);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    EXPECT_NEAR(found.first[f], 1.0 / 3, 1e-10);
    EXPECT_NEAR(found.second[f], 1.0 / 3, 1e-10);
  }
}

TEST(FaceCurvatures, OfATriangleWithoutAreaAreZero) {
  Points positions(3, 3);
  positions << 0, 0, 0, 1, 0, 0, 2, 0, 0;
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  const FaceCurvatures found = face_curvatures(positions, triangles, Points::Ones(3, 3));
  EXPECT_EQ(found.first[0], 0);
  EXPECT_EQ(found.first_direction.norm(), 0);
}

}  // namespace
}  // namespace batten
