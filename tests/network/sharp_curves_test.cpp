#include "batten/network/sharp_curves.hpp"

#include "network/sharp_networks.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

using Eigen::Vector3d;

SharpSplit split_of(const CurveNetwork& network) {
  return split_at_sharp_curves(network, find_cycles(network).cycles);
}

TEST(SharpCurves, EveryFaceOfACubeHasItsOwnCornersAndItsNormal) {
  const CurveNetwork network = samples::cube_edges(4, true);
  const SharpSplit split = split_of(network);
  // 8 corners in three faces, 3 samples inside each of 12 edges in two.
  EXPECT_EQ(split.network.positions.rows(), 8 * 3 + 12 * 3 * 2);
  ASSERT_EQ(split.cycles.size(), 6u);
  for (const NetworkCycle& cycle : split.cycles) {
    const std::vector<int>& loop = cycle.loops.front().vertices;
    const Vector3d middle = [&] {
      Vector3d sum = Vector3d::Zero();
      for (const int v : loop) sum += split.network.positions.row(v).transpose();
      return Vector3d(sum / static_cast<double>(loop.size()));
    }();
    for (const int v : loop) EXPECT_LT((split.network.normals.row(v).transpose() - middle).norm(), 1e-12);
  }
}

TEST(SharpCurves, SidesOfARimHaveTheNormalsOfCapAndWall) {
  const SharpSplit split = split_of(samples::capped_cylinder(5, 12, true));  // walls have 48 samples
  int caps = 0;
  for (const NetworkCycle& cycle : split.cycles) {
    const std::vector<int>& loop = cycle.loops.front().vertices;
    const bool is_cap = cycle.loops.size() == 1 && loop.size() == 60;
    caps += is_cap;
    for (const int v : loop) {
      const Vector3d p = split.network.positions.row(v);
      const Vector3d expected = is_cap ? Vector3d(0, 0, p.z() - 1) : Vector3d(p.x(), p.y(), 0);
      EXPECT_LT((split.network.normals.row(v).transpose() - expected).norm(), 5e-4) << p.transpose();
    }
  }
  EXPECT_EQ(caps, 2);
}

TEST(SharpCurves, NormalsBesideACurvedEdgeAreThoseOfTheSurfacesThatMeetThere) {
  const CurveNetwork network = samples::lens(12, true);
  const SharpSplit split = split_of(network);
  for (const NetworkCycle& cycle : split.cycles) {
    double height = 0;
    for (const int v : cycle.loops.front().vertices) height += split.network.positions(v, 2);
    for (const int v : cycle.loops.front().vertices) {
      const Vector3d p = split.network.positions.row(v);
      EXPECT_LT((split.network.normals.row(v).transpose() - samples::lens_normal(p, height > 0)).norm(), 2e-3)
          << p.transpose();
    }
  }
  // Positions are copied, not moved.
  for (std::size_t v = 0; v < split.place.size(); ++v)
    EXPECT_EQ(split.network.positions.row(static_cast<Eigen::Index>(v)),
              network.positions.row(split.place[v]));
}

TEST(SharpCurves, NormalsThatACurveCarriesAreTaken) {
  CurveNetwork network = samples::capped_cylinder(4, 12, true);
  NetworkCurve& rim = network.curves[1];  // its left, looking along it from outside, is the cap
  const auto n = static_cast<Eigen::Index>(rim.vertices.size());
  rim.left_normals = Points::Zero(n, 3);
  for (Eigen::Index k = 0; k < n; ++k)
    rim.left_normals.row(k) =
        (Vector3d(0, 0, 1) + 0.1 * Vector3d(network.positions(rim.vertices[static_cast<std::size_t>(k)], 0),
                                            network.positions(rim.vertices[static_cast<std::size_t>(k)], 1),
                                            0))
            .normalized();
  const SharpSplit split = split_of(network);
  int seen = 0;
  for (const NetworkCycle& cycle : split.cycles) {
    const std::vector<int>& loop = cycle.loops.front().vertices;
    if (loop.size() != 48 || split.network.positions(loop.front(), 2) < 1) continue;
    for (const int v : loop) {
      ++seen;
      EXPECT_NEAR(split.network.normals(v, 2), 1 / std::sqrt(1.01), 1e-12);
    }
  }
  EXPECT_EQ(seen, 48);
}

TEST(SharpCurves, AnEdgeFadesOutWhereItEndsInTheSurface) {
  CurveNetwork network = samples::octahedral_sphere(6);
  // A quarter of the equator, from one node to the next.
  NetworkCurve& equator = network.curves[2];
  NetworkCurve quarter = equator;
  const NetworkTopology topology = network_topology(network);
  for (const NetworkSegment& segment : topology.segments)
    if (segment.curve == 2) quarter.vertices = segment.vertices;
  quarter.sharp = true;
  std::vector<NetworkCurve> rest;
  bool first = true;
  for (const NetworkSegment& segment : topology.segments)
    if (segment.curve == 2 && !(segment.vertices == quarter.vertices)) {
      NetworkCurve piece = equator;
      piece.vertices = segment.vertices;
      if (first)
        equator = piece;
      else
        rest.push_back(piece);
      first = false;
    }
  network.curves.insert(network.curves.end(), rest.begin(), rest.end());
  network.curves.push_back(quarter);
  const SharpSplit split = split_of(network);
  // Every sample inside the quarter twice, its two ends once, with the normals they had.
  EXPECT_EQ(split.network.positions.rows(),
            network.positions.rows() + static_cast<Eigen::Index>(quarter.vertices.size()) - 2);
  for (const int v : {quarter.vertices.front(), quarter.vertices.back()})
    EXPECT_EQ(split.network.normals.row(v), network.normals.row(v));
}

TEST(SharpCurves, CurvesAreSharpWhereNormalsOnBothSidesSaySo) {
  const auto found = [](const CurveNetwork& network) {
    std::vector<int> curves;
    for (const SharpFinding& finding : find_sharp_curves(network, find_cycles(network).cycles))
      curves.push_back(finding.curve);
    return curves;
  };
  EXPECT_EQ(found(samples::lens(12, false)), std::vector<int>{0});
  EXPECT_TRUE(found(samples::octahedral_sphere(4)).empty());  // 22° from sample to sample, and smooth
}

}  // namespace
}  // namespace batten
