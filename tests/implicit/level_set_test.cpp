#include "batten/implicit/level_set.hpp"

#include "implicit/strokes.hpp"
#include "sanitizers.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/quality.hpp"

namespace batten {
namespace {

/// √(x² + y² + z²) − 1 and, around z, a torus of radii 1 and 0.4: distances.
const ScalarField kSphere{[](const Eigen::Vector3d& x) { return x.norm() - 1; },
                          [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x.normalized()); }};
double torus_distance(const Eigen::Vector3d& x) {
  return std::hypot(std::hypot(x[0], x[1]) - 1, x[2]) - 0.4;
}
const ScalarField kTorus{torus_distance, [](const Eigen::Vector3d& x) {
                           const Eigen::Vector3d ring = Eigen::Vector3d(x[0], x[1], 0).normalized();
                           return Eigen::Vector3d((x - ring).normalized());
                         }};

Points seeds_of(const CurveNetwork& strokes) {
  Points seeds(strokes.positions.rows() / 4, 3);
  for (Eigen::Index i = 0; i < seeds.rows(); ++i) seeds.row(i) = strokes.positions.row(4 * i);
  return seeds;
}

TEST(LevelSet, OfATorusIsOne) {
  const Points seeds = seeds_of(test::torus_strokes());
  LevelSetOptions options;
  options.edge_length = test::repeated(0.1, 0.15);
  const TriangleMesh mesh = level_set(kTorus, seeds, 0.3, options);
  const MeshTopology topology = mesh_topology(mesh.triangles, mesh.n_vertices());
  EXPECT_TRUE(topology.is_watertight());
  EXPECT_EQ(topology.genus(), 1);
  EXPECT_GT(enclosed_volume(mesh.positions, mesh.triangles), 0);  // it faces along the gradient
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    EXPECT_NEAR(torus_distance(mesh.positions.row(v).transpose()), 0, 1e-4);
  const MeshQuality quality = mesh_quality(mesh.positions, mesh.triangles);
  EXPECT_GT(quality.min_angle, 20 * test::kTurn / 360);
  EXPECT_NEAR(quality.mean_edge, options.edge_length, 0.25 * options.edge_length);
}

TEST(LevelSet, KeepsSeedsWhereTheyAre) {
  Points seeds = seeds_of(test::sphere_strokes(3, 0.15, 0));
  seeds *= 1.001;  // near the surface is enough
  LevelSetOptions options;
  options.edge_length = 0.2;
  const TriangleMesh mesh = level_set(kSphere, seeds, 0.3, options);
  for (Eigen::Index i = 0; i < seeds.rows(); ++i)
    EXPECT_LT((mesh.positions.rowwise() - seeds.row(i)).rowwise().norm().minCoeff(), 1e-12) << i;
}

// A saddle goes on beyond every sphere, and two cones meet in a point: refinement towards closed surfaces
// with even triangles would never end.
TEST(LevelSet, EndsWhereTheSurfaceDoesNotCloseOrMeetsItself) {
  const ScalarField saddle{
      [](const Eigen::Vector3d& x) { return x[2] - 0.5 * x[0] * x[1]; },
      [](const Eigen::Vector3d& x) { return Eigen::Vector3d(-0.5 * x[1], -0.5 * x[0], 1); }};
  const ScalarField cones{
      [](const Eigen::Vector3d& x) { return x[0] * x[0] + x[1] * x[1] - x[2] * x[2]; },
      [](const Eigen::Vector3d& x) { return Eigen::Vector3d(2 * x[0], 2 * x[1], -2 * x[2]); }};
  Points on_saddle(25, 3), on_cones(24, 3);
  for (int i = 0; i < 25; ++i) {
    const double x = 0.5 * (i % 5) - 1, y = 0.5 * (i / 5) - 1;
    on_saddle.row(i) << x, y, 0.5 * x * y;
  }
  for (int i = 0; i < 24; ++i) {
    const double a = test::kTurn * (i % 6) / 6, r = (i < 12 ? 1 : -1) * (i % 12 < 6 ? 0.5 : 1.0);
    on_cones.row(i) << r * std::cos(a), r * std::sin(a), r;
  }
  LevelSetOptions options;
  options.edge_length = test::repeated(0.2, 0.4);
  for (const auto& [field, seeds] : {std::pair(saddle, on_saddle), std::pair(cones, on_cones)}) {
    const TriangleMesh mesh = level_set(field, seeds, 0.1, options);
    const MeshTopology topology = mesh_topology(mesh.triangles, mesh.n_vertices());
    EXPECT_TRUE(topology.is_manifold());
    EXPECT_GT(topology.n_boundary_loops, 0);
    EXPECT_GT(mesh.n_triangles(), 50);
  }
}

TEST(LevelSet, RefusesWhatItCannotDo) {
  LevelSetOptions options;
  EXPECT_NE(options.problem()->find("edge_length"), std::string::npos);
  const Points seeds = seeds_of(test::sphere_strokes());
  EXPECT_THROW(level_set(kSphere, seeds, 0.3, options), InvalidInput);
  options.edge_length = 1e-6;
  EXPECT_THROW(level_set(kSphere, seeds, 0.3, options), InvalidInput);  // too many triangles
  options.edge_length = 0.2;
  options.smallest_angle = 40;
  EXPECT_THROW(level_set(kSphere, seeds, 0.3, options), InvalidInput);
  options.smallest_angle = 25;
  EXPECT_THROW(level_set(kSphere, Points(3, 3), 0.3, options), InvalidInput);
  Points flat = seeds;
  flat.col(2).setZero();
  EXPECT_THROW(level_set(kSphere, flat, 0.3, options), InvalidInput);
  options.edge_length = 0.05;
  EXPECT_THROW(
      level_set(kSphere, seeds, 0.3, options, Progress([](std::string_view, double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace batten
