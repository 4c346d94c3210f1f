#include "batten/remeshing/crossings.hpp"

#include "remeshing/surfaces.hpp"

#include <filesystem>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/remeshing/remesh.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// A box of 1 × 1 × 0.1, its edges marked.
struct Slab {
  TriangleMesh input;
  FeatureChains features;
  std::optional<RemeshState> state;

  Slab() : input(fixtures::cube(6)) {
    input.positions.col(2) *= 0.1;
    HalfedgeMesh mesh(input.positions, input.triangles);
    FeatureOptions options;
    options.crease_angle = radians(30.0);
    options.corner_angle = radians(40.0);
    features = mark_features(mesh, options);
    state.emplace(mesh, features, Eigen::VectorXd::Constant(mesh.vertex_capacity(), 1.0 / 6));
  }
  std::size_t crossings() const {
    const HalfedgeMesh::Compact compact = state->mesh.compacted();
    return self_intersections(compact.positions, compact.triangles).size();
  }
  double largest_distance() const {
    const TriangleTree tree(input.positions, input.triangles);
    return distances(tree.closest(state->mesh.compacted().positions)).maxCoeff();
  }
};

// Vertices of the upper side that hang out below go back to the side that they face, not to the nearest.
TEST(MendCrossings, PutsVerticesBackOnTheirOwnSide) {
  Slab slab;
  int moved = 0;
  for (int v = 0; v < slab.state->mesh.vertex_capacity(); ++v) {
    const Vector3d p = slab.state->mesh.position(v);
    if (!slab.state->is_free(v) || p.z() < 0.099 || moved == 3) continue;
    slab.state->mesh.set_position(v, p - Vector3d(0, 0, 0.12));
    moved += 1;
  }
  ASSERT_EQ(moved, 3);
  ASSERT_GT(slab.crossings(), 0U);
  EXPECT_EQ(mend_crossings(*slab.state, slab.input.positions, slab.input.triangles, 0), 0U);
  EXPECT_EQ(slab.crossings(), 0U);
  EXPECT_LT(slab.largest_distance(), 1e-9);
  EXPECT_EQ(slab.state->mesh.breach(), "");
}

TEST(MendCrossings, LeavesAloneWhatDoesNotCrossAndWhatMay) {
  Slab slab;
  EXPECT_EQ(mend_crossings(*slab.state, slab.input.positions, slab.input.triangles, 0), 0U);
  EXPECT_EQ(slab.state->mesh.compacted().positions, slab.input.positions);
  int v = 0;
  while (!slab.state->is_free(v) || slab.input.positions(v, 2) < 0.099) ++v;
  const Vector3d below = slab.state->mesh.position(v) - Vector3d(0, 0, 0.12);
  slab.state->mesh.set_position(v, below);
  const std::size_t crossing = slab.crossings();
  ASSERT_GT(crossing, 0U);
  EXPECT_EQ(mend_crossings(*slab.state, slab.input.positions, slab.input.triangles, crossing), crossing);
  EXPECT_EQ(slab.state->mesh.position(v), below);
}

// The casting has thin walls: at two and three times its edges 5 and 6 pairs of triangles crossed without
// mending.
TEST(MendCrossings, KeepsTheWallsOfACastingApart) {
  const std::string path = BATTEN_SHARED_DATA "/meshes/casting.off";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const TriangleMesh input = read_mesh(path);
  ASSERT_TRUE(self_intersections(input.positions, input.triangles, 1).empty());
  for (const double ratio : {2.0, 3.0}) {
    RemeshOptions options;
    options.edge_length = ratio * mesh_quality(input.positions, input.triangles).mean_edge;
    const RemeshResult result = remesh(input, options);
    EXPECT_EQ(result.report.crossings, 0U);
    EXPECT_TRUE(self_intersections(result.mesh.positions, result.mesh.triangles, 1).empty());
  }
}

}  // namespace
}  // namespace batten
