#include "batten/render/corner_normals.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {
namespace {

/// Two unit squares that meet at a right angle along the y axis: one level, one upright.
TriangleMesh corner() {
  TriangleMesh mesh;
  mesh.positions.resize(6, 3);
  mesh.positions << 0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, -1, 0, 1, -1;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 2, 3, 0, 3, 1, 0, 1, 5, 0, 5, 4;
  return mesh;
}

TEST(CornerNormals, AreThoseOfTheSideWhereTheAngleIsLarger) {
  const Points normals = corner_normals(corner(), radians(50));
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(normals.row(i).isApprox(Eigen::RowVector3d(0, 0, 1))) << i;
  for (int i = 6; i < 12; ++i) EXPECT_TRUE(normals.row(i).isApprox(Eigen::RowVector3d(-1, 0, 0))) << i;
}

TEST(CornerNormals, AreThoseOfTheVerticesWhereEveryEdgeIsSmooth) {
  const TriangleMesh mesh = corner();
  const Points corners = corner_normals(mesh, kPi);
  const Points vertices = vertex_normals(mesh.positions, mesh.triangles);
  for (Eigen::Index i = 0; i < corners.rows(); ++i)
    EXPECT_TRUE(corners.row(i).isApprox(vertices.row(mesh.triangles(i / 3, i % 3)), 1e-12)) << i;
  // Along the fold both squares meet with a right angle each: half way between their normals.
  EXPECT_TRUE(corners.row(0).isApprox(Eigen::RowVector3d(-1, 0, 1).normalized(), 1e-12));
}

}  // namespace
}  // namespace batten
