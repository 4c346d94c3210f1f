#include "batten/surfacing/crossing_removal.hpp"

#include "mesh/shapes.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/mesh/welding.hpp"

namespace batten {
namespace {

TriangleMesh closed_sphere(int n, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  TriangleMesh mesh = fixtures::as_mesh(fixtures::sphere(n, 1, centre));
  mesh.triangles = welded_triangles(mesh.triangles, weld_borders(mesh.positions, mesh.triangles, 1e-9));
  return mesh;
}

TEST(UncrossedMesh, LeavesAMeshWithoutCrossingsAsItIs) {
  const TriangleMesh mesh = closed_sphere(6);
  const UncrossedMesh result = uncrossed_mesh(mesh);
  EXPECT_EQ(result.crossings_before, 0u);
  EXPECT_EQ(result.mesh.positions, mesh.positions);
  EXPECT_EQ(result.mesh.triangles, mesh.triangles);
}

// One vertex pulled aside, below the surface and out again: the spot is made anew, and the sphere is whole
// again.
TEST(UncrossedMesh, MakesASpotAnew) {
  for (const int vertex : {0, 40, 77}) {
    TriangleMesh mesh = closed_sphere(24);
    const double volume = enclosed_volume(mesh.positions, mesh.triangles);
    const Eigen::RowVector3d p = mesh.positions.row(vertex);
    const Eigen::RowVector3d aside = p.cross(Eigen::RowVector3d(0.3, -0.5, 0.7)).normalized();
    mesh.positions.row(vertex) = 1.01 * (p + 0.25 * aside).normalized();
    ASSERT_FALSE(self_intersections(mesh.positions, mesh.triangles).empty()) << vertex;
    const UncrossedMesh result = uncrossed_mesh(mesh);
    EXPECT_GT(result.crossings_before, 0u);
    EXPECT_TRUE(result.crossings.empty()) << vertex;
    EXPECT_TRUE(self_intersections(result.mesh.positions, result.mesh.triangles).empty());
    const MeshTopology topology = mesh_topology(result.mesh.triangles, result.mesh.n_vertices());
    EXPECT_TRUE(topology.is_watertight());
    EXPECT_EQ(topology.euler_characteristic, 2);
    EXPECT_NEAR(enclosed_volume(result.mesh.positions, result.mesh.triangles), volume, 0.01 * volume);
  }
}

// The union of two spheres would be another shape; they stay, and are told.
TEST(UncrossedMesh, LeavesPartsThatPassThroughEachOther) {
  const TriangleMesh one = closed_sphere(6), other = closed_sphere(6, {1.2, 0.1, 0});
  TriangleMesh both;
  both.positions.resize(one.n_vertices() + other.n_vertices(), 3);
  both.positions << one.positions, other.positions;
  both.triangles.resize(one.n_triangles() + other.n_triangles(), 3);
  both.triangles << one.triangles, other.triangles.array() + static_cast<int>(one.n_vertices());
  const UncrossedMesh result = uncrossed_mesh(both);
  EXPECT_EQ(result.crossings.size(), result.crossings_before);
  EXPECT_EQ(result.mesh.positions, both.positions);
}

}  // namespace
}  // namespace batten
