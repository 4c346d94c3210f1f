#include "batten/mesh/normals.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/mesh/areas.hpp"

namespace batten {
namespace {

// Counter-clockwise seen from above is up.
TEST(FaceNormals, FollowTheRightHandAndAreZeroWithoutArea) {
  Points positions(4, 3);
  positions << 0, 0, 0, 2, 0, 0, 0, 3, 0, 4, 0, 0;
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 0, 1, 3;  // the second lies on a line
  const Points normals = face_normals(positions, triangles);
  EXPECT_EQ(normals.row(0), Eigen::RowVector3d(0, 0, 1));
  EXPECT_EQ(normals.row(1).norm(), 0);
}

// The corner of a cube: three squares meet at right angles; weights by angle give the diagonal however the
// squares are cut, weights by area or by number would not.
TEST(VertexNormals, DoNotDependOnHowFlatPiecesAreCut) {
  Points positions(7, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1;
  Triangles cut(4, 3);  // the square in z = 0 as two triangles at the corner, the others as one
  cut << 0, 2, 4, 0, 4, 1, 0, 3, 2, 0, 1, 3;
  const Eigen::RowVector3d normal = vertex_normals(positions, cut).row(0);
  EXPECT_NEAR((normal + Eigen::RowVector3d(1, 1, 1) / std::sqrt(3.0)).norm(), 0, 1e-15);
}

TEST(MeanNormalAngle, IsTheAngleOfATurnAsAWhole) {
  const Shape sphere = fixtures::sphere(8);
  const Points turned =
      sphere.positions * Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix().transpose();
  EXPECT_EQ(mean_normal_angle(sphere.positions, sphere.positions, sphere.triangles), 0);
  // Turned about z by 90 degrees a normal of polar angle θ moves by acos(cos² θ).
  const Points normals = face_normals(sphere.positions, sphere.triangles);
  double sum = 0;
  for (Eigen::Index f = 0; f < normals.rows(); ++f) sum += std::acos(normals(f, 2) * normals(f, 2));
  EXPECT_NEAR(mean_normal_angle(sphere.positions, turned, sphere.triangles),
              sum / static_cast<double>(normals.rows()), 1e-12);
}

// The angle-weighted normal of a cube's corner is its diagonal however the faces are cut; the faces give the
// axes.
TEST(VertexNormals, OfACubePointAlongTheDiagonals) {
  Points corners(8, 3);
  for (int i = 0; i < 8; ++i) corners.row(i) << (i & 1 ? 1 : -1), (i & 2 ? 1 : -1), (i & 4 ? 1 : -1);
  Triangles cube(12, 3);
  cube << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7,
      1, 7, 5;
  const Points normals = vertex_normals(corners, cube);
  for (int i = 0; i < 8; ++i) EXPECT_LT((normals.row(i) - corners.row(i).normalized()).norm(), 1e-15);
  EXPECT_NEAR(surface_area(corners, cube), 24, 1e-12);
  EXPECT_NEAR(enclosed_volume(corners, cube), 8, 1e-12);
  EXPECT_LT((face_normals(corners, cube).row(0) - Eigen::RowVector3d(0, 0, -1)).norm(), 1e-15);
  const Points far = corners.rowwise() + Eigen::RowVector3d(1e6, -1e6, 1e6);
  EXPECT_NEAR(enclosed_volume(far, cube), 8, 1e-8);
}

// One triangle turned by 30° about an edge, one turned over, one without area: (30° + 180°) / 2.
TEST(MeanNormalAngle, LeavesOutTrianglesWithoutArea) {
  Points a(5, 3);
  a << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 2, 0, 0;
  Triangles triangles(3, 3);
  triangles << 0, 1, 2, 1, 0, 3, 0, 1, 4;
  Points b = a;
  b.row(2) << 0, std::cos(kPi / 6), std::sin(kPi / 6);
  b.row(3) << 0.5, 3, 0;
  EXPECT_NEAR(mean_normal_angle(a, b, triangles), radians(105.0), 1e-14);
  EXPECT_EQ(mean_normal_angle(a, a, triangles), 0);
  EXPECT_EQ(mean_normal_angle(a, b, triangles.bottomRows(1)), 0);
}

// Normals of a sphere are its points; the mesh errs by the square of the edge length.
TEST(VertexNormals, ConvergeOnASphere) {
  double previous = 1;
  for (const int n : {8, 16, 32}) {
    const Shape sphere = fixtures::sphere(n);
    // Inside the octahedron's faces, where every vertex has all its triangles.
    const Points normals = vertex_normals(sphere.positions, sphere.triangles);
    double sum = 0;
    for (Eigen::Index v = 0; v < normals.rows(); ++v)
      sum += (normals.row(v) - sphere.positions.row(v)).norm();
    const double mean = sum / static_cast<double>(normals.rows());
    EXPECT_LT(mean, 0.7 * previous) << n;
    previous = mean;
  }
}

}  // namespace
}  // namespace batten
