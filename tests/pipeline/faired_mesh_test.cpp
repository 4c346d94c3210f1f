#include "batten/pipeline/faired_mesh.hpp"

#include "fairing/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {
namespace {

TriangleMesh as_mesh(const fixtures::Mesh& shape, double noise) {
  TriangleMesh mesh;
  mesh.positions =
      noise > 0 ? add_gaussian_noise(shape.positions, shape.triangles, noise, 5) : shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
}

TEST(FairedMesh, IsThatOfTheRoomBelowWithItsFigures) {
  TriangleMesh mesh = as_mesh(fixtures::cube(8), 0.2);
  mesh.normals = vertex_normals(mesh.positions, mesh.triangles);
  mesh.vertex_values["kept"] = Eigen::VectorXd::LinSpaced(mesh.n_vertices(), 0, 1);
  FairingOptions options;
  options.method = FairingMethod::MeanCurvature;
  const FairedMesh faired = faired_mesh(mesh, options);
  const FairingResult below = fair(mesh.positions, mesh.triangles, options);
  EXPECT_EQ(faired.mesh.positions, below.positions);
  EXPECT_EQ(faired.noise, below.noise);
  EXPECT_EQ(faired.iterations, below.iterations);
  EXPECT_EQ(faired.time_step, below.time_step);
  EXPECT_EQ(faired.largest_move, below.largest_move);
  EXPECT_FALSE(faired.strategy.has_value());
  EXPECT_TRUE(faired.topology.is_watertight());
  // The flow rounds a cube: it loses volume, and normals turn.
  ASSERT_TRUE(faired.volume_change.has_value());
  EXPECT_NEAR(
      1 + *faired.volume_change,
      enclosed_volume(below.positions, mesh.triangles) / enclosed_volume(mesh.positions, mesh.triangles),
      1e-12);
  EXPECT_LT(*faired.volume_change, 0);
  EXPECT_GT(faired.mean_normal_change, 0);
  EXPECT_EQ(faired.mesh.normals, vertex_normals(below.positions, mesh.triangles));
  EXPECT_EQ(faired.mesh.vertex_values.at("kept"), mesh.vertex_values.at("kept"));
  EXPECT_EQ(faired.times.stages().front().first, "fair");
}

TEST(FairedMesh, WarnsWhereACleanMeshIsLeftAlone) {
  const TriangleMesh mesh = as_mesh(fixtures::cube(16), 0);
  const FairedMesh faired = faired_mesh(mesh);
  EXPECT_EQ(faired.strategy, FairingStrategy::None);
  EXPECT_EQ(faired.mesh.positions, mesh.positions);
  ASSERT_EQ(faired.warnings.size(), 1u);
  EXPECT_NE(faired.warnings[0].find("`noise`"), std::string::npos);
}

TEST(FairedMesh, AnOpenMeshEnclosesNothing) {
  const FairedMesh faired = faired_mesh(as_mesh(fixtures::sheet(6, 6, 1, 1), 0.1));
  EXPECT_FALSE(faired.volume_change.has_value());
  EXPECT_EQ(faired.topology.n_boundary_loops, 1);
}

TEST(FairedMesh, RefusesAndCancels) {
  const TriangleMesh mesh = as_mesh(fixtures::cube(4), 0.1);
  EXPECT_THROW(faired_mesh({}), InvalidInput);
  FairingOptions options;
  options.iterations = -1;
  EXPECT_THROW(faired_mesh(mesh, options), InvalidInput);
  EXPECT_THROW(faired_mesh(mesh, {}, Progress([](std::string_view, double) { return false; })), Cancelled);
}

}  // namespace
}  // namespace batten
