#include "batten/surfacing/flattening.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {
namespace {

/// Square patches over [0, 1]², n cells each way: patch p lies at height `levels[p]` and bulges by
/// `bulges[p]` in its middle. Their borders are the network.
SurfaceResult sheets(int n, const std::vector<double>& levels, const std::vector<double>& bulges) {
  const int side = n + 1, each = side * side;
  SurfaceResult surface;
  const auto n_patches = static_cast<int>(levels.size());
  surface.mesh.positions.resize(n_patches * each, 3);
  surface.mesh.triangles.resize(n_patches * 2 * n * n, 3);
  int f = 0;
  for (int p = 0; p < n_patches; ++p)
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j) {
        const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
        const double height = bulges[static_cast<size_t>(p)] * std::sin(kPi * x) * std::sin(kPi * y);
        const int v = p * each + i * side + j;
        surface.mesh.positions.row(v) << x, y, levels[static_cast<size_t>(p)] + height;
        surface.on_network.push_back(i == 0 || j == 0 || i == n || j == n);
        if (i == n || j == n) continue;
        for (const auto& [b, c] : {std::pair(v + side, v + side + 1), std::pair(v + side + 1, v + 1)}) {
          surface.mesh.triangles.row(f++) << v, b, c;
          surface.patch_of_triangle.push_back(p);
        }
      }
  surface.mesh.normals = vertex_normals(surface.mesh.positions, surface.mesh.triangles);
  surface.n_cycles = n_patches;
  return surface;
}

// A bulge of 0.6 goes through a sheet 0.2 above its curves; half of it still does, the membrane, which is
// flat over a flat square, does not. The third sheet is far away.
TEST(FlattenCrossingPatches, PullsABulgeBackBehindItsNeighbour) {
  const SurfaceResult before = sheets(10, {0, 0.2, 3}, {0.6, 0, 0.5});
  SurfaceResult surface = before;
  const FlatteningReport report = flatten_crossing_patches(surface);
  EXPECT_GT(report.crossings_before, 10u);
  EXPECT_EQ(report.crossings_after, 0u);
  EXPECT_EQ(report.patches, std::vector<int>({0, 1}));
  EXPECT_TRUE(self_intersections(surface.mesh.positions, surface.mesh.triangles).empty());
  const Eigen::Index each = 11 * 11;
  EXPECT_LT(surface.mesh.positions.col(2).head(each).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((surface.mesh.positions.col(2).segment(each, each).array() - 0.2).abs().maxCoeff(), 1e-12);
  EXPECT_EQ(surface.mesh.positions.bottomRows(each), before.mesh.positions.bottomRows(each));
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v)
    if (surface.on_network[static_cast<size_t>(v)]) {
      EXPECT_EQ(surface.mesh.positions.row(v), before.mesh.positions.row(v)) << v;
      EXPECT_EQ(surface.mesh.normals.row(v), before.mesh.normals.row(v)) << v;
    } else if (v < each) {
      EXPECT_NEAR(surface.mesh.normals(v, 2), 1, 1e-9) << v;
    }
  ASSERT_EQ(surface.warnings.size(), 1u);
  EXPECT_NE(surface.warnings[0].find("patches 0, 1"), std::string::npos) << surface.warnings[0];
}

// Through a sheet at two thirds of its height, half the bulge is enough: the rest of the shape stays.
TEST(FlattenCrossingPatches, TakesHalfWhereThatIsEnough) {
  SurfaceResult surface = sheets(10, {0, 0.4}, {0.6, 0});
  const FlatteningReport report = flatten_crossing_patches(surface);
  EXPECT_GT(report.crossings_before, 0u);
  EXPECT_EQ(report.crossings_after, 0u);
  EXPECT_NEAR(surface.mesh.positions.col(2).head(121).maxCoeff(), 0.3, 1e-9);
}

TEST(FlattenCrossingPatches, LeavesSoundSurfacesBitForBit) {
  const SurfaceResult before = sheets(8, {0, 1}, {0.3, 0.3});
  SurfaceResult surface = before;
  const FlatteningReport report = flatten_crossing_patches(surface);
  EXPECT_TRUE(report.patches.empty());
  EXPECT_EQ(report.crossings_before, 0u);
  EXPECT_EQ(surface.mesh.positions, before.mesh.positions);
  EXPECT_EQ(surface.mesh.normals, before.mesh.normals);
  EXPECT_TRUE(surface.warnings.empty());
}

// Where the borders themselves stand on either side of the other patch, no filling keeps them apart:
// crossings are left, never more than before, they are counted as they are, and curves stay.
TEST(FlattenCrossingPatches, TellsWhatItCannotMend) {
  SurfaceResult before = sheets(6, {0, 0}, {0, 0});
  // The second sheet stands upright through the middle of the first.
  for (Eigen::Index v = 49; v < 98; ++v) {
    const Eigen::RowVector3d lying = before.mesh.positions.row(v);
    before.mesh.positions.row(v) << lying.x(), 0.45, lying.y() - 0.5;
  }
  before.mesh.normals = vertex_normals(before.mesh.positions, before.mesh.triangles);
  SurfaceResult surface = before;
  const FlatteningReport report = flatten_crossing_patches(surface);
  EXPECT_GT(report.crossings_before, 0u);
  EXPECT_GT(report.crossings_after, 0u);
  EXPECT_LE(report.crossings_after, report.crossings_before);
  EXPECT_EQ(report.crossings_after,
            self_intersections(surface.mesh.positions, surface.mesh.triangles, 100000).size());
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v)
    if (surface.on_network[static_cast<size_t>(v)]) {
      EXPECT_EQ(surface.mesh.positions.row(v), before.mesh.positions.row(v)) << v;
    }
}

}  // namespace
}  // namespace batten
