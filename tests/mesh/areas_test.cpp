#include "batten/mesh/areas.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

TEST(Areas, OfARightTriangleAndOfALine) {
  Points positions(4, 3);
  positions << 0, 0, 5, 2, 0, 5, 0, 3, 5, 4, 0, 5;
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 0, 1, 3;
  const Eigen::VectorXd areas = face_areas(positions, triangles);
  EXPECT_EQ(areas[0], 3);
  EXPECT_EQ(areas[1], 0);
  EXPECT_EQ(surface_area(positions, triangles), 3);
}

TEST(Areas, OfASphereConvergeAtSecondOrder) {
  const auto error = [](int n) {
    const Shape sphere = fixtures::sphere(n, 2);
    return 4 * kPi * 4 - surface_area(sphere.positions, sphere.triangles);
  };
  EXPECT_GT(error(32), 0);  // inscribed
  EXPECT_NEAR(std::log2(error(16) / error(32)), 2, 0.1);
}

// A tetrahedron of three unit edges at right angles has the volume 1/6, wherever it stands; inside out, −1/6.
TEST(EnclosedVolume, OfATetrahedronDoesNotDependOnWhereItStands) {
  Points positions(4, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  Triangles triangles(4, 3);
  triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  EXPECT_NEAR(enclosed_volume(positions, triangles), 1.0 / 6, 1e-16);
  const Points far = positions.rowwise() + Eigen::RowVector3d(1e6, -2e6, 3e6);
  EXPECT_NEAR(enclosed_volume(far, triangles), 1.0 / 6, 1e-9);
  const Triangles inside_out = triangles.rowwise().reverse();
  EXPECT_NEAR(enclosed_volume(positions, inside_out), -1.0 / 6, 1e-16);
}

/// The box [0, 1] × [0, 2] × [0, 3] of twelve triangles, outwards.
void box(Points& positions, Triangles& triangles) {
  positions.resize(8, 3);
  for (int i = 0; i < 8; ++i) positions.row(i) << i % 2, 2 * (i / 2 % 2), 3 * (i / 4);
  triangles.resize(12, 3);
  triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3,
      5, 3, 7, 5;
}

TEST(Areas, OfABoxAreThoseOfItsSides) {
  Points positions;
  Triangles triangles;
  box(positions, triangles);
  const Eigen::VectorXd areas = face_areas(positions, triangles);
  EXPECT_DOUBLE_EQ(areas[0], 1);  // half of 1 × 2
  EXPECT_DOUBLE_EQ(areas[4], 1.5);
  EXPECT_DOUBLE_EQ(areas[8], 3);
  EXPECT_DOUBLE_EQ(surface_area(positions, triangles), 22);
}

TEST(Volume, HasTheSignOfTheOrientation) {
  Points positions;
  Triangles triangles;
  box(positions, triangles);
  EXPECT_DOUBLE_EQ(enclosed_volume(positions, triangles), 6);
  EXPECT_DOUBLE_EQ(enclosed_volume(positions, triangles.rowwise().reverse()), -6);
  EXPECT_EQ(enclosed_volume(Points(0, 3), Triangles(0, 3)), 0);
}

// Measured from the middle of the box: with the origin of the coordinates 1e5 away the determinants would be
// 1e10 and more, and the difference that the volume is would keep five digits. What rounding of the positions
// leaves is 1e-10.
TEST(Volume, KeepsItsDigitsFarFromTheOrigin) {
  Points positions;
  Triangles triangles;
  box(positions, triangles);
  positions.rowwise() += Eigen::RowVector3d(1e5, -2e5, 3e5) + Eigen::RowVector3d(1, 1, 1) / 3;
  EXPECT_NEAR(enclosed_volume(positions, triangles), 6, 1e-8);
}

}  // namespace
}  // namespace batten
