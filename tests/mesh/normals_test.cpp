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

}  // namespace
}  // namespace batten
