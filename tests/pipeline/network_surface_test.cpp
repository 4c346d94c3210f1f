#include "batten/pipeline/network_surface.hpp"

#include "network/sample_networks.hpp"
#include "network/torus_grid.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {
namespace {

TEST(NetworkSurface, IsTheSurfaceOfTheRoomBelowWithItsChecks) {
  const CurveNetwork network = samples::octahedral_sphere(8);
  const NetworkSurface surface = network_surface(network);
  // Three great circles meet in the six corners of an octahedron: twelve arcs around eight patches.
  EXPECT_EQ(surface.n_curves, network.curves.size());
  EXPECT_EQ(surface.n_nodes, 6u);
  EXPECT_EQ(surface.n_segments, 12u);
  EXPECT_EQ(surface.n_cycles, 8);
  EXPECT_TRUE(surface.topology.is_watertight());
  EXPECT_EQ(surface.topology.euler_characteristic, 2);
  EXPECT_TRUE(surface.is_sound());
  EXPECT_TRUE(surface.warnings.empty());
  EXPECT_FALSE(surface.flattening.has_value());
  EXPECT_EQ(surface.mesh.positions, surface_network(network).mesh.positions);
}

TEST(NetworkSurface, HasNoVertexThatNoTriangleUses) {
  CurveNetwork network = samples::octahedral_sphere(8);
  const NetworkSurface whole = network_surface(network);
  // A stray sample in front of all others: every number of a vertex is shifted by one.
  const Eigen::Index n = network.positions.rows();
  for (Points* points : {&network.positions, &network.normals}) {
    Points longer(n + 1, 3);
    longer << Eigen::RowVector3d(0, 0, 1), *points;
    *points = longer;
  }
  for (NetworkCurve& curve : network.curves)
    for (int& v : curve.vertices) ++v;
  const NetworkSurface surface = network_surface(network);
  const std::set<int> used(surface.mesh.triangles.data(),
                           surface.mesh.triangles.data() + surface.mesh.triangles.size());
  EXPECT_EQ(static_cast<Eigen::Index>(used.size()), surface.mesh.n_vertices());
  EXPECT_EQ(surface.mesh.n_vertices(), whole.mesh.n_vertices());
  EXPECT_EQ(surface.mesh.normals.rows(), surface.mesh.n_vertices());
  EXPECT_NEAR((surface.mesh.positions.rowwise().norm().array() - 1).abs().maxCoeff(), 0, 1e-3);
}

TEST(NetworkSurface, RelativeEdgeLengthsAreOfTheDiameter) {
  const CurveNetwork network = samples::octahedral_sphere(8);
  const double diameter = bounding_box_diagonal(network.positions);
  NetworkSurfaceOptions relative, absolute;
  relative.edge_length = Length{0.05, Length::Kind::Relative};
  absolute.edge_length = Length{0.05 * diameter, Length::Kind::Plain};
  const NetworkSurface by_part = network_surface(network, relative);
  EXPECT_EQ(by_part.mesh.positions, network_surface(network, absolute).mesh.positions);
  EXPECT_NE(by_part.mesh.n_vertices(), network_surface(network).mesh.n_vertices());
  EXPECT_DOUBLE_EQ(by_part.diameter, diameter);
}

TEST(NetworkSurface, BadOptionsAreNamed) {
  NetworkSurfaceOptions options;
  options.edge_length = Length{0, Length::Kind::Plain};
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_NE(options.problem()->find("edge_length"), std::string::npos);
  EXPECT_THROW(network_surface(samples::octahedral_sphere(4), options), InvalidInput);
  options.edge_length.reset();
  options.surface.base_order = 4;
  EXPECT_THROW(network_surface(samples::octahedral_sphere(4), options), InvalidInput);
}

TEST(CurvesSurface, FillsNetworksAsTheyAreAndStrokesAfterCleaning) {
  const CurvesSurface filled = curves_surface(samples::octahedral_sphere(8));
  EXPECT_FALSE(filled.strokes.has_value());
  EXPECT_EQ(filled.surface.topology.genus().value_or(-1), 0);

  const CurvesSurface drawn = curves_surface(fixtures::unwelded(fixtures::torus_grid(4, 6, 10, 0.1)));
  ASSERT_TRUE(drawn.strokes.has_value());
  EXPECT_EQ(drawn.strokes->estimate.cycles.size(), 24u);  // 4 × 6 faces of the grid
  EXPECT_EQ(drawn.surface.topology.genus().value_or(-1), 1);
  EXPECT_TRUE(drawn.surface.flattening.has_value());
  EXPECT_EQ(drawn.network.positions, drawn.strokes->network.positions);
}

}  // namespace
}  // namespace batten
