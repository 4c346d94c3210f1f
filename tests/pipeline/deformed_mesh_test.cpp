#include "batten/pipeline/deformed_mesh.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {
namespace {

constexpr int kAround = 12, kAlong = 16;

/// An open tube along z, 12 vertices around, of radius 0.3 and length 2.
TriangleMesh tube() {
  return fixtures::as_mesh(fixtures::grid(kAround, kAlong, true, false, [](double u, double v) {
    return Eigen::Vector3d(0.3 * std::cos(2 * kPi * u), 0.3 * std::sin(2 * kPi * u), 2 * v);
  }));
}

/// The lower ring stays, the upper one moves.
Handles ends(const TriangleMesh& mesh, double angle, const Eigen::Vector3d& translation) {
  Handles handles;
  HandleMotion motion;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (mesh.positions(v, 2) < 1e-9) handles.fixed.push_back(v);
    if (mesh.positions(v, 2) > 2 - 1e-9) motion.vertices.push_back(v);
  }
  motion.angle = angle;
  motion.translation = translation;
  handles.moved.push_back(motion);
  return handles;
}

TEST(DeformedMesh, MeetsTheHandlesAndIsThatOfTheRoomBelow) {
  TriangleMesh mesh = tube();
  mesh.normals = vertex_normals(mesh.positions, mesh.triangles);
  const Handles handles = ends(mesh, radians(40.0), {0.1, 0, 0.2});
  const DeformedMesh result = deformed_mesh(mesh, handles);
  EXPECT_EQ(result.n_fixed, static_cast<std::size_t>(kAround));
  EXPECT_EQ(result.n_moved, static_cast<std::size_t>(kAround));
  const Points targets = handles.targets(mesh.positions);
  const std::vector<int> vertices = handles.vertices();
  for (std::size_t i = 0; i < vertices.size(); ++i)
    EXPECT_LT((result.mesh.positions.row(vertices[i]) - targets.row(static_cast<Eigen::Index>(i))).norm(),
              1e-9);
  // Below 45 degrees the motion is one part: one call of the deformer.
  const Deformer deformer(mesh.positions, mesh.triangles, vertices);
  EXPECT_EQ(result.mesh.positions, deformer.deform(targets).positions);
  EXPECT_EQ(result.curvature_term, deformer.curvature_term());
  EXPECT_EQ(result.mesh.normals, vertex_normals(result.mesh.positions, mesh.triangles));
  EXPECT_FALSE(result.base_vertices.has_value());
}

// A half turn in one step would begin at a linear solution that pinches the tube to its axis in the middle.
TEST(DeformedMesh, LargeTurnsAreMadeInPartsAndKeepTheTubeOpen) {
  const TriangleMesh mesh = tube();
  const DeformedMesh result = deformed_mesh(mesh, ends(mesh, radians(180.0), {0, 0, 0}));
  const double least = result.mesh.positions.leftCols<2>().rowwise().norm().minCoeff();
  EXPECT_GT(least, 0.15);  // half the radius
}

TEST(DeformedMesh, TwoResolutionsMeetTheHandlesToo) {
  const TriangleMesh mesh = tube();
  const Handles handles = ends(mesh, 0, {0, 0, 0.3});
  DeformedMeshOptions options;
  options.multiresolution = true;
  const DeformedMesh result = deformed_mesh(mesh, handles, options);
  ASSERT_TRUE(result.base_vertices.has_value());
  EXPECT_EQ(*result.base_vertices, mesh.n_vertices());  // so small a mesh is its own base
  EXPECT_NEAR(result.mesh.positions.col(2).maxCoeff(), 2.3, 1e-9);
}

TEST(DeformedMesh, WarnsWhereTheIterationsEndTooEarly) {
  const TriangleMesh mesh = tube();
  DeformedMeshOptions options;
  options.deform.max_iterations = 1;
  const DeformedMesh result = deformed_mesh(mesh, ends(mesh, radians(40.0), {0, 0, 0}), options);
  EXPECT_FALSE(result.report.converged);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.back().find("`iterations`"), std::string::npos);
}

TEST(DeformedMesh, RefusesAndCancels) {
  const TriangleMesh mesh = tube();
  Handles handles = ends(mesh, 0, {0, 0, 0.3});
  EXPECT_THROW(deformed_mesh({}, handles), InvalidInput);
  EXPECT_THROW(deformed_mesh(mesh, handles, {}, Progress([](std::string_view, double) { return false; })),
               Cancelled);
  DeformedMeshOptions options;
  options.deform.soft_weight = -1;
  EXPECT_THROW(deformed_mesh(mesh, handles, options), InvalidInput);
  handles.fixed.push_back(static_cast<int>(mesh.n_vertices()));
  EXPECT_THROW(deformed_mesh(mesh, handles), InvalidInput);
}

}  // namespace
}  // namespace batten
