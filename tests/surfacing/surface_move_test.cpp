#include "network/sample_networks.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/surfacing/surface.hpp"

// Moves of a kept surface. The subject is a sphere of eight patches over three great circles.
namespace batten {
namespace {

constexpr int kSteps = 6;  // per quarter circle

/// Bytes in use, 0 where they are not told (another C library, a sanitizer's allocator).
std::size_t bytes_in_use() {
#if defined(__GLIBC__)
  return mallinfo2().uordblks;
#else
  return 0;
#endif
}

/// A vertex inside a quarter circle and the node at its end, by their coordinates.
int vertex_near(const CurveNetwork& network, const Eigen::RowVector3d& place) {
  Eigen::Index nearest = 0;
  (network.positions.rowwise() - place).rowwise().norm().minCoeff(&nearest);
  return static_cast<int>(nearest);
}

std::set<int> members(const std::vector<VertexRange>& ranges) {
  std::set<int> all;
  for (const VertexRange& range : ranges)
    for (Eigen::Index v = range.first; v < range.end; ++v) all.insert(static_cast<int>(v));
  return all;
}

std::set<int> vertices_of_patches(const SurfaceResult& surface, const std::set<int>& patches) {
  std::set<int> vertices;
  for (Eigen::Index f = 0; f < surface.mesh.triangles.rows(); ++f)
    if (patches.count(surface.patch_of_triangle[static_cast<std::size_t>(f)]) > 0)
      for (int k = 0; k < 3; ++k)
        if (const int v = surface.mesh.triangles(f, k); !surface.on_network[static_cast<std::size_t>(v)])
          vertices.insert(v);
  return vertices;
}

std::set<int> patches_around(const SurfaceResult& surface, int vertex) {
  std::set<int> patches;
  for (Eigen::Index f = 0; f < surface.mesh.triangles.rows(); ++f)
    if ((surface.mesh.triangles.row(f).array() == vertex).any())
      patches.insert(surface.patch_of_triangle[static_cast<std::size_t>(f)]);
  return patches;
}

// A vertex of a side moves the two patches beside it and a node its four, and all that changed is named.
TEST(SurfaceMove, ChangesThePatchesAroundTheMovedCurveAndNamesThem) {
  const CurveNetwork network = samples::octahedral_sphere(kSteps);
  SurfaceSolver solver(network);
  const TriangleMesh built = solver.result().mesh;
  const int side = vertex_near(network, {std::sqrt(0.5), std::sqrt(0.5), 0}),
            node = vertex_near(network, {1, 0, 0});
  for (const bool positions_only : {false, true})
    for (const auto& [vertex, n_patches] : {std::pair(side, 2), std::pair(node, 4)}) {
      solver.move(network.positions, network.normals);
      Points positions = network.positions;
      positions.row(vertex) *= 1.02;
      const SurfaceMove move = solver.move(positions, network.normals, {.positions_only = positions_only});
      EXPECT_EQ(move.patches_solved, n_patches);
      std::set<int> expected = vertices_of_patches(solver.result(), patches_around(solver.result(), vertex));
      expected.insert(vertex);
      EXPECT_EQ(members(move.positions), expected);
      EXPECT_TRUE(move.normals.empty());
      const Points& now = solver.result().mesh.positions;
      for (Eigen::Index v = 0; v < now.rows(); ++v)
        if (expected.count(static_cast<int>(v)) == 0) {
          EXPECT_EQ(now.row(v), built.positions.row(v)) << v;
        }
      EXPECT_EQ(now.row(vertex), positions.row(vertex));
      // Back again: what had changed changes back.
      EXPECT_EQ(members(solver.move(network.positions, network.normals).positions), expected);
      EXPECT_EQ(now, built.positions);
    }
}

// A turned normal alone is felt by the patches around it.
TEST(SurfaceMove, FollowsATurnedNormal) {
  const CurveNetwork network = samples::octahedral_sphere(kSteps);
  SurfaceSolver solver(network);
  const int side = vertex_near(network, {std::sqrt(0.5), std::sqrt(0.5), 0});
  Points normals = network.normals;
  normals.row(side) = (normals.row(side) + Eigen::RowVector3d(0, 0, 0.3)).normalized();
  const SurfaceMove move = solver.move(network.positions, normals);
  EXPECT_EQ(move.patches_solved, 2);
  EXPECT_LT((solver.result().mesh.normals.row(side) - normals.row(side)).norm(), 1e-15);
  EXPECT_TRUE(members(move.normals).count(side) == 1);
  EXPECT_TRUE(members(move.positions).count(side) == 0);
  EXPECT_GT(members(move.positions).size(), 10U);
  // Positions alone do not feel it.
  EXPECT_EQ(solver.move(network.positions, normals, {.positions_only = true}).patches_solved, 0);
}

// Solving for all patches where only some are touched: their neighbours answer too, and what they answer is
// small beside the move; where all are touched it is the same.
TEST(SurfaceMove, ReachesAllPatchesWhenAsked) {
  const CurveNetwork network = samples::octahedral_sphere(kSteps);
  SurfaceSolver solver(network);
  Points positions = network.positions;
  positions.row(vertex_near(network, {std::sqrt(0.5), std::sqrt(0.5), 0})) *= 1.02;
  solver.move(positions, network.normals);
  const Points touched = solver.result().mesh.positions;
  EXPECT_EQ(solver.move(positions, network.normals, {.reach = SurfaceReach::All}).patches_solved, 8);
  const double difference = (solver.result().mesh.positions - touched).rowwise().norm().maxCoeff();
  EXPECT_GT(difference, 0);
  EXPECT_LT(difference, 0.2 * 0.02);
  positions = 1.01 * network.positions;
  solver.move(positions, network.normals);
  const Points of_touched = solver.result().mesh.positions;
  solver.move(positions, network.normals, {.reach = SurfaceReach::All});
  EXPECT_EQ(solver.result().mesh.positions, of_touched);
}

// A shifted network carries its surface with it, whatever the method: all reproduce constants.
TEST(SurfaceMove, ShiftsTheSurfaceWithItsNetworkWithEveryMethod) {
  const CurveNetwork network = samples::octahedral_sphere(kSteps);
  for (const SurfaceMethod method :
       {SurfaceMethod::Curvature, SurfaceMethod::Harmonic, SurfaceMethod::Biharmonic,
        SurfaceMethod::Triharmonic, SurfaceMethod::BiharmonicNormals})
    for (const bool soft : {false, true}) {
      SurfaceOptions options;
      options.method = method;
      options.soft_constraints = soft;
      SurfaceSolver solver(network, options);
      const Points built = solver.result().mesh.positions;
      solver.move(network.positions.rowwise() + Eigen::RowVector3d(0.1, -0.2, 0.3), network.normals);
      const Points shifted = built.rowwise() + Eigen::RowVector3d(0.1, -0.2, 0.3);
      EXPECT_LT((solver.result().mesh.positions - shifted).cwiseAbs().maxCoeff(), 1e-9)
          << static_cast<int>(method) << soft;
    }
}

// A thousand random moves of all kinds leave no trace: then the kept solver gives what a fresh one gives, to
// 1e-9 of the size, and holds no more memory than before.
TEST(SurfaceMove, AThousandRandomMovesLeaveNoTrace) {
  const CurveNetwork network = samples::octahedral_sphere(4);
  SurfaceSolver kept(network);
  Random random(7);
  const auto changed = [&](double share) {
    CurveNetwork other = network;
    for (Eigen::Index v = 0; v < other.positions.rows(); ++v) {
      if (random.uniform(0, 1) > share) continue;
      for (int k = 0; k < 3; ++k) other.positions(v, k) += 0.02 * random.normal();
      if (random.uniform(0, 1) < 0.5)
        other.normals.row(v) = (other.normals.row(v) +
                                0.1 * Eigen::RowVector3d(random.normal(), random.normal(), random.normal()))
                                   .normalized();
    }
    return other;
  };
  std::size_t bytes_before = 0;
  const SurfaceMoveOptions no_reach{.reach = static_cast<SurfaceReach>(7)};
  EXPECT_EQ(no_reach.problem(), "reach must be Touched or All, got number 7");
  EXPECT_THROW(kept.move(network.positions, network.normals, no_reach), InvalidInput);
  for (int round = 0; round < 1000; ++round) {
    const CurveNetwork other = changed(round % 3 == 0 ? 1 : 0.04);
    SurfaceMoveOptions options;
    options.positions_only = round % 2 == 1;
    if (round % 5 == 0) options.reach = SurfaceReach::All;
    kept.move(other.positions, other.normals, options);
    if (round == 99) bytes_before = bytes_in_use();
  }
  // What an allocator rounds differs by a few per cent; 60 bytes left behind by each move would show.
  EXPECT_LE(static_cast<double>(bytes_in_use()), 1.1 * static_cast<double>(bytes_before));
  const double size = 2 * std::sqrt(3.0);
  for (const double share : {0.03, 1.0}) {
    const CurveNetwork last = changed(share);
    SurfaceSolver fresh(network);
    kept.move(last.positions, last.normals);
    fresh.move(last.positions, last.normals);
    EXPECT_LT((kept.result().mesh.positions - fresh.result().mesh.positions).cwiseAbs().maxCoeff(),
              1e-9 * size);
    EXPECT_LT((kept.result().mesh.normals - fresh.result().mesh.normals).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(kept.result().folded_triangles, fresh.result().folded_triangles);
    EXPECT_EQ(kept.result().degenerate_triangles, fresh.result().degenerate_triangles);
    EXPECT_EQ(kept.result().warnings, fresh.result().warnings);
  }
}

}  // namespace
}  // namespace batten
