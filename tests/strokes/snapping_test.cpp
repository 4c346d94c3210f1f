#include "batten/strokes/snapping.hpp"

#include "network/sphere_network.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/network/diagnosis.hpp"

namespace batten {
namespace {

using fixtures::add_polyline;
using fixtures::line;

// A cross and a T, drawn without shared vertices; what must meet is known by construction.
CurveNetwork unwelded(double scale = 1) {
  CurveNetwork network;
  add_polyline(network, scale * line({-5, 0, 0}, {5, 0, 0}, 24));
  add_polyline(network, scale * line({0, -5, 0.02}, {0, 5, 0.02}, 20));
  add_polyline(network, scale * line({2.3, 0.03, 0}, {2.3, 4, 0}, 9));
  add_polyline(network, scale * line({2.31, 4, 0}, {5, 4, 0}, 9));
  return network;
}

TEST(Welded, JoinsCrossingsEndsAndTJunctions) {
  for (const double scale : {1.0, 1e-3, 1e3}) {
    const auto [network, report] = welded(unwelded(scale), 0.05 * scale);
    const NetworkTopology topology = network_topology(network);
    EXPECT_EQ(topology.n_components, 1);
    // four arms of the cross, the arm with the T cut once more, the two other lines
    EXPECT_EQ(topology.segments.size(), 7u);
    EXPECT_EQ(network.curves.size(), 4u);
    EXPECT_EQ(network.curves[2].vertices.back(), network.curves[3].vertices.front());
    EXPECT_EQ(report.n_merged_vertices, 3);
    for (const NetworkFinding& finding : diagnose_network(network)) {
      EXPECT_NE(finding.defect, NetworkDefect::Crossing) << finding.sentence;
      EXPECT_NE(finding.defect, NetworkDefect::TJunction) << finding.sentence;
    }
  }
}

// No point of a curve moves further than the tolerance: every old sample is within it of the new polyline's
// samples or unchanged.
TEST(Welded, MovesNoPointFurtherThanTheTolerance) {
  const CurveNetwork before = unwelded(), after = welded(before, 0.05).network;
  for (size_t c = 0; c < before.curves.size(); ++c)
    for (const int v : before.curves[c].vertices) {
      double nearest = 1e9;
      for (const int w : after.curves[c].vertices)
        nearest = std::min(nearest, (after.positions.row(w) - before.positions.row(v)).norm());
      EXPECT_LE(nearest, 0.05);
    }
}

// The two ends lie at one place but for rounding, wherever a circle begins.
TEST(Welded, ClosesACircleWhereverItBegins) {
  for (int start = 0; start < 360; ++start) {
    CurveNetwork network;
    Points circle(41, 3);
    for (int k = 0; k <= 40; ++k) {
      const double a = 2 * kPi * (k / 40.0 + start / 360.0);
      circle.row(k) << std::cos(a), std::sin(a), 0;
    }
    add_polyline(network, circle);
    const WeldedNetwork result = welded(network, 0.01);
    ASSERT_EQ(result.network.curves.size(), 1u);
    EXPECT_TRUE(result.network.curves[0].closed()) << start;
  }
}

TEST(Welded, LeavesAWeldedNetworkAsItIs) {
  const CurveNetwork once = welded(unwelded(), 0.05).network;
  const auto [twice, report] = welded(once, 0.05);
  EXPECT_EQ(once.positions, twice.positions);
  EXPECT_EQ(report.n_merged_vertices, 0);
  EXPECT_EQ(report.n_inserted_nodes, 0);
  const CurveNetwork sphere = fixtures::three_great_circles(10);
  const CurveNetwork same = welded(sphere, 0.01).network;
  EXPECT_EQ(same.positions, sphere.positions);
  EXPECT_EQ(same.normals, sphere.normals);
  for (size_t c = 0; c < 3; ++c) EXPECT_EQ(same.curves[c].vertices, sphere.curves[c].vertices);
}

TEST(Welded, ClosesACurveWhoseEndsAlmostMeet) {
  CurveNetwork network;
  Points ring(50, 3);
  for (int i = 0; i < 50; ++i) ring.row(i) << std::cos(2 * kPi * i / 49.1), std::sin(2 * kPi * i / 49.1), 0;
  add_polyline(network, ring);
  const CurveNetwork closed = welded(network, 0.05).network;
  ASSERT_EQ(closed.curves.size(), 1u);
  EXPECT_TRUE(closed.curves[0].closed());
}

TEST(Welded, RefusesAToleranceThatIsNotPositive) {
  for (const double bad : {0.0, -1.0, std::nan("")}) EXPECT_THROW(welded(unwelded(), bad), InvalidInput);
  CurveNetwork broken = unwelded();
  broken.curves[0].vertices[3] = 1000;
  EXPECT_THROW(welded(broken, 0.1), InvalidInput);
}

}  // namespace
}  // namespace batten
