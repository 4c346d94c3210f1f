#include "network/sample_networks.hpp"
#include "network/torus_grid.hpp"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/io/network_io.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/strokes/stroke_network.hpp"
#include "batten/surfacing/surface.hpp"

// Surfaces over patches and normals that were found from curves alone.
namespace batten {
namespace {

using Eigen::Vector3d;

// The same patches, found or given, give the same mesh.
TEST(SurfaceOfGivenCycles, IsThatOfTheCyclesFound) {
  const CurveNetwork network = samples::octahedral_sphere(8);
  const SurfaceResult found = surface_network(network);
  const SurfaceResult given = surface_network(network, find_cycles(network).cycles);
  EXPECT_EQ(given.mesh.triangles, found.mesh.triangles);
  EXPECT_EQ(given.mesh.positions, found.mesh.positions);
}

TEST(SurfaceOfGivenCycles, RefusesCyclesOfAnotherNetwork) {
  const CurveNetwork network = samples::octahedral_sphere(4);
  std::vector<NetworkCycle> cycles = find_cycles(network).cycles;
  EXPECT_THROW(surface_network(network, std::vector<NetworkCycle>()), InvalidInput);
  cycles[0].loops[0].vertices[0] = 1000;
  EXPECT_THROW(surface_network(network, cycles), InvalidInput);
}

// Three great circles without normals: by symmetry the estimate is exact, so the sphere comes out as with
// normals, 0.01 % being a tenth of the distance between a chord of 4 % and its arc.
TEST(SurfaceOfASketch, IsASphereOverItsCircles) {
  CurveNetwork network = samples::without_normals(samples::octahedral_sphere(16));
  const EstimatedCycles estimate = estimate_cycles(network);
  network.normals = estimate.normals;
  const SurfaceResult surface = surface_network(network, estimate.cycles);
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v)
    EXPECT_NEAR(surface.mesh.positions.row(v).norm(), 1, 1e-3);
  EXPECT_EQ(surface.folded_triangles, 0);
}

// Circles of a torus of radii 2 and 1 (diameter of its box 8.7): mean distance from it in per cent.
TEST(SurfaceOfASketch, IsNearlyATorusOverItsCircles) {
  const StrokeNetwork made =
      stroke_network(fixtures::unwelded(fixtures::torus_grid(8, 8, 20, 0)), {.step = 0.03});
  const SurfaceResult surface = surface_network(made.network, made.estimate.cycles);
  double mean = 0;
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v) {
    const Vector3d p = surface.mesh.positions.row(v);
    mean += std::abs(std::hypot(std::hypot(p.x(), p.y()) - 2, p.z()) - 1) / 8.7;
  }
  mean /= static_cast<double>(surface.mesh.n_vertices());
  EXPECT_LT(mean, 0.003);
  const MeshTopology topology = mesh_topology(surface.mesh.triangles, surface.mesh.n_vertices());
  EXPECT_TRUE(topology.is_watertight());
  EXPECT_EQ(topology.genus(), std::optional<int>(1));
}

// Twelve straight edges of a cube and no normals: its sides bulge, and do not sink in.
TEST(SurfaceOfASketch, OverTheEdgesOfACubeBulges) {
  CurveNetwork strokes;
  strokes.positions.resize(24, 3);
  for (int a = 0, row = 0; a < 8; ++a)
    for (int axis = 0; axis < 3; ++axis) {
      if ((a >> axis & 1) != 0) continue;
      NetworkCurve curve;
      for (const int corner : {a, a | 1 << axis}) {
        strokes.positions.row(row) << (corner & 1), (corner >> 1 & 1), (corner >> 2 & 1);
        curve.vertices.push_back(row++);
      }
      strokes.curves.push_back(std::move(curve));
    }
  const StrokeNetwork made = stroke_network(strokes);
  const SurfaceResult surface = surface_network(made.network, made.estimate.cycles);
  EXPECT_GT(enclosed_volume(surface.mesh.positions, surface.mesh.triangles), 1.2);
  EXPECT_EQ(surface.folded_triangles, 0);
}

// Three arcs of two edges between two poles: every patch is a quadrangle of the same two poles, and could
// have the straight line between them for a diagonal. The surface is a sphere, so no edge has three
// triangles.
TEST(SurfaceOfASketch, HasNoEdgeOfThreeTriangles) {
  for (const double flat : {0.2, 1.0, 3.0}) {
    samples::NetworkBuilder builder;
    for (int i = 0; i < 3; ++i)
      builder.curve(
          2, false,
          [&](double t) {
            const double angle = 2 * kPi * i / 3, r = t == 0.5 ? 1 : 0;
            return Vector3d(r * std::cos(angle), r * std::sin(angle), flat * (2 * t - 1));
          },
          [](const Vector3d&) { return Vector3d(0, 0, 1); });
    CurveNetwork network = samples::without_normals(builder.build());
    const EstimatedCycles estimate = estimate_cycles(network);
    ASSERT_EQ(estimate.cycles.size(), 3u);
    network.normals = estimate.normals;
    const SurfaceResult surface = surface_network(network, estimate.cycles);
    const MeshTopology topology = mesh_topology(surface.mesh.triangles, surface.mesh.n_vertices());
    EXPECT_TRUE(topology.is_watertight());
    EXPECT_TRUE(topology.is_manifold());
    EXPECT_EQ(topology.genus(), std::optional<int>(0));
  }
}

class ConnectedSketches : public testing::TestWithParam<std::pair<const char*, int>> {};

// Connected sketches give a closed surface of the genus of the object drawn.
TEST_P(ConnectedSketches, GiveAClosedSurface) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/curves/" + GetParam().first;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  StrokeNetworkOptions options;
  options.step = 0.03;  // coarse, for builds with sanitizers
  const StrokeNetwork made = stroke_network(read_network(path), options);
  const SurfaceResult surface = surface_network(made.network, made.estimate.cycles);
  const MeshTopology topology = mesh_topology(surface.mesh.triangles, surface.mesh.n_vertices());
  EXPECT_TRUE(topology.is_watertight());
  EXPECT_EQ(topology.n_components, 1);
  EXPECT_EQ(topology.genus(), std::optional<int>(GetParam().second));
  EXPECT_EQ(surface.folded_triangles, 0);
}
INSTANTIATE_TEST_SUITE_P(SurfaceOfASketch, ConnectedSketches,
                         testing::Values(std::pair("sketch_trebol_flowrep.obj", 0),
                                         std::pair("sketch_torus.obj", 1), std::pair("sketch_box.obj", 0),
                                         std::pair("sketch_spherecylinder.obj", 0)),
                         [](const auto& sketch) {
                           const std::string file = sketch.param.first;
                           return file.substr(7, file.find('.') - 7);
                         });

}  // namespace
}  // namespace batten
