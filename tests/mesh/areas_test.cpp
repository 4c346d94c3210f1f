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

}  // namespace
}  // namespace batten
