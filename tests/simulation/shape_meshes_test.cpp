#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/simulation/shape_meshes_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

double area(const ShapeMeshBuilder& mesh) {
  double twice = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d& a = mesh.positions[static_cast<size_t>(t[0])];
    const Vector3d& b = mesh.positions[static_cast<size_t>(t[1])];
    const Vector3d& c = mesh.positions[static_cast<size_t>(t[2])];
    twice += (b - a).cross(c - a).norm();
  }
  return twice / 2;
}

/// Signed: positive where triangles are counter-clockwise from outside.
double volume(const ShapeMeshBuilder& mesh) {
  double six = 0;
  for (const Eigen::Vector3i& t : mesh.triangles)
    six += mesh.positions[static_cast<size_t>(t[0])].dot(
        mesh.positions[static_cast<size_t>(t[1])].cross(mesh.positions[static_cast<size_t>(t[2])]));
  return six / 6;
}

// An octahedron has 8 faces, each cut into n² triangles; its volume is 4/3. On the sphere the volume comes
// with the second power of the edge.
TEST(ShapeMeshes, StarsAreFinerOctahedra) {
  const auto flat = [](const Vector3d& d) { return Vector3d(d / d.cwiseAbs().sum()); };
  const auto round = [](const Vector3d& d) { return d; };
  for (const int n : {1, 2, 5}) {
    const ShapeMeshBuilder mesh = star_mesh(n, flat);
    EXPECT_EQ(mesh.positions.size(), static_cast<size_t>(4 * n * n + 2));
    EXPECT_EQ(mesh.triangles.size(), static_cast<size_t>(8 * n * n));
    EXPECT_NEAR(volume(mesh), 4.0 / 3, 1e-12);
    EXPECT_NEAR(area(mesh), 4 * std::sqrt(3.0), 1e-12);
  }
  const double coarse = 4 * kPi / 3 - volume(star_mesh(8, round));
  const double fine = 4 * kPi / 3 - volume(star_mesh(16, round));
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.05);
}

TEST(ShapeMeshes, GridsCoverTheirSquareAndWrapAround) {
  const auto place = [](double u, double v) { return Vector3d(3 * u, 2 * v, 1); };
  const ShapeMeshBuilder open = grid_mesh(4, 3, false, false, place);
  EXPECT_EQ(open.positions.size(), 20U);
  EXPECT_EQ(open.triangles.size(), 24U);
  EXPECT_NEAR(area(open), 6, 1e-12);
  EXPECT_NEAR(volume(open), 2, 1e-12);  // the cone from the origin to the plane z = 1
  EXPECT_EQ(grid_mesh(4, 3, true, false, place).positions.size(), 16U);
  EXPECT_EQ(grid_mesh(4, 3, true, true, place).positions.size(), 12U);
}

// A regular polygon of 6 r sides.
TEST(ShapeMeshes, DiscsArePolygonsOfRings) {
  for (const int rings : {1, 2, 7}) {
    const ShapeMeshBuilder mesh = disc_mesh(rings, [](double x, double y) { return Vector3d(x, y, 1); });
    EXPECT_EQ(mesh.positions.size(), static_cast<size_t>(1 + 3 * rings * (rings + 1)));
    EXPECT_EQ(mesh.triangles.size(), static_cast<size_t>(6 * rings * rings));
    const double exact = 3 * rings * std::sin(kPi / (3 * rings));
    EXPECT_NEAR(area(mesh), exact, 1e-12);
    EXPECT_NEAR(volume(mesh), exact / 3, 1e-12);
  }
}

}  // namespace
}  // namespace batten::detail
