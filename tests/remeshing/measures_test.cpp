#include "batten/remeshing/measures.hpp"

#include "mesh/shapes.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

/// A torus with radii 2 and 0.7, bent out of even by `uneven` (0: all quads alike).
TriangleMesh torus(int n, double uneven = 0) {
  return fixtures::as_mesh(fixtures::grid(2 * n, n, true, true, [uneven](double u, double v) {
    const double a = 2 * kPi * (u + uneven * std::sin(2 * kPi * u)), b = 2 * kPi * v;
    const double r = 2 + 0.7 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.7 * std::sin(b));
  }));
}

TEST(RemeshMeasures, AreZeroForTheSameMesh) {
  const TriangleMesh mesh = torus(24);
  const RemeshMeasures measures = remesh_measures(mesh, mesh);
  EXPECT_EQ(measures.curvature_change, 0);
  EXPECT_EQ(measures.edge_variance_change, 0);
  EXPECT_EQ(measures.area_variance_change, 0);
  EXPECT_EQ(measures.curvature_variance_change, 0);
  EXPECT_LT(measures.mean_distance, 1e-15);
  EXPECT_LT(measures.normal_error, 1e-7);  // points on edges may see the neighbour: measure zero
  EXPECT_EQ(measures.area_variance, measures.original_area_variance);
}

// Every figure is relative: neither the unit nor a turn of both may matter. A power of two and a quarter
// turn, so that roundings and ties between nearest vertices are the same.
TEST(RemeshMeasures, AreFreeOfUnitAndTurn) {
  const TriangleMesh a = torus(24, 0.05), b = torus(20);
  TriangleMesh a2 = a, b2 = b;
  Eigen::Matrix3d R;
  R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  for (TriangleMesh* mesh : {&a2, &b2}) mesh->positions = (mesh->positions * R.transpose() / 1024).eval();
  const RemeshMeasures m = remesh_measures(a, b), m2 = remesh_measures(a2, b2);
  EXPECT_NEAR(m2.curvature_change, m.curvature_change, 1e-6);
  EXPECT_NEAR(m2.edge_variance_change, m.edge_variance_change, 1e-6);
  EXPECT_NEAR(m2.area_variance_change, m.area_variance_change, 1e-6);
  EXPECT_NEAR(m2.curvature_variance_change, m.curvature_variance_change, 1e-6);
  EXPECT_NEAR(m2.mean_distance, m.mean_distance, 1e-9);
  EXPECT_NEAR(m2.normal_error, m.normal_error, 1e-5);  // points on edges have two normals to choose from
}

// A square tilted about its middle by an angle: that is the angle between all normals, and the mean distance
// of points to the tilted plane is that of |x| sin(angle) over the vertices.
TEST(RemeshMeasures, SeeATilt) {
  TriangleMesh flat;
  const Shape shape = fixtures::grid(
      10, 10, false, false, [](double u, double v) { return Eigen::Vector3d(2 * u - 1, 2 * v - 1, 0); });
  flat.positions = shape.positions;
  flat.triangles = shape.triangles;
  TriangleMesh tilted = flat;
  const double angle = radians(3.0);
  tilted.positions.col(2) = std::tan(angle) * flat.positions.col(0);
  tilted.positions.col(0) *= 2;  // reaches beyond, so that every foot lies on it
  tilted.positions.col(2) *= 2;
  const RemeshMeasures measures = remesh_measures(flat, tilted);
  EXPECT_NEAR(measures.normal_error, angle, 1e-9);
  EXPECT_NEAR(measures.mean_distance,
              flat.positions.col(0).cwiseAbs().mean() * std::sin(angle) / std::sqrt(8.0), 1e-12);
  EXPECT_EQ(measures.curvature_change, 0);  // no curvature to compare with
}

// Equilateral triangles of areas 1 and 3: areas a and 3a per vertex, so Var / (N Ā²) = a² / (2a)² = 1/4.
TEST(RemeshMeasures, AreaVarianceIsRelative) {
  TriangleMesh two;
  two.positions.resize(6, 3);
  const double s = std::sqrt(3.0);
  two.positions << 0, 0, 0, 2, 0, 0, 1, s, 0, 5, 0, 0, 5 + 2 * s, 0, 0, 5 + s, 3, 0;
  two.triangles.resize(2, 3);
  two.triangles << 0, 1, 2, 3, 4, 5;
  EXPECT_NEAR(remesh_measures(two, two).area_variance, 0.25, 1e-12);
}

TEST(RemeshMeasures, RefuseEmptyMeshes) {
  EXPECT_THROW(remesh_measures(TriangleMesh{}, torus(8)), InvalidInput);
  EXPECT_THROW(remesh_measures(torus(8), TriangleMesh{}), InvalidInput);
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(remesh_measures(torus(8), torus(8), radians(30.0), stop), Cancelled);
}

}  // namespace
}  // namespace batten
