#include "batten/network/sharp_curves.hpp"

#include "network/sharp_networks.hpp"

#include <gtest/gtest.h>

#include "batten/network/sharp_chain_detail.hpp"

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

// Two rims and nothing between them: the caps are flat, and the wall goes straight from rim to rim.
TEST(SharpCurves, AWallWithoutCurvesGoesStraightToTheOtherRim) {
  samples::NetworkBuilder builder;
  for (const double z : {0.0, 2.0})
    builder.curve(
        48, false, [=](double t) { return Vector3d(std::cos(2 * kPi * t), std::sin(2 * kPi * t), z); },
        [](const Vector3d& p) { return Vector3d(p.x(), p.y(), p.z() - 1); });
  CurveNetwork network = builder.build();
  network.curves[0].sharp = network.curves[1].sharp = true;
  const SharpSplit split = split_of(network);
  ASSERT_EQ(split.cycles.size(), 3u);
  for (const NetworkCycle& cycle : split.cycles)
    for (const NetworkCycle::Loop& loop : cycle.loops)
      for (const int v : loop.vertices) {
        const Vector3d p = split.network.positions.row(v);
        const Vector3d expected =
            cycle.loops.size() == 1 ? Vector3d(0, 0, p.z() - 1) : Vector3d(p.x(), p.y(), 0);
        EXPECT_LT((split.network.normals.row(v).transpose() - expected).norm(), 1e-9) << p.transpose();
      }
}

// A line along x with normals that turn about it as a parabola, known at four places of uneven distance: the
// others are found exactly.
TEST(SharpChain, AnglesOfAParabolaAreFoundExactly) {
  const auto normal = [](double x) {
    const double angle = 0.3 * x + 0.9 * x * x;
    return Vector3d(0, std::sin(angle), std::cos(angle));
  };
  detail::SharpChain chain;
  const int known[] = {0, 3, 5, 10};
  for (int k = 0; k <= 10; ++k) {
    chain.points.emplace_back(0.1 * k, 0, 0);
    chain.references.emplace_back(0, 0, 1);
    chain.is_node.push_back(0);
    chain.normals.emplace_back(Vector3d::Zero());
  }
  for (const int k : known) chain.normals[static_cast<std::size_t>(k)] = normal(0.1 * k);
  detail::interpolate_normals(chain);
  for (int k = 0; k <= 10; ++k)
    EXPECT_LT((chain.normals[static_cast<std::size_t>(k)] - normal(0.1 * k)).norm(), 1e-12) << k;
}

// Samples of a circle at uneven angles: its tangent, at the ends of the chain too.
TEST(SharpChain, TangentsOfUnevenSamplesAreThoseOfTheCircle) {
  detail::SharpChain chain;
  const double angles[] = {-0.1, 0, 0.3};
  for (const double a : angles) chain.points.emplace_back(std::cos(a), std::sin(a), 0);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_LT((chain.tangent(k) - Vector3d(-std::sin(angles[k]), std::cos(angles[k]), 0)).norm(), 0.01) << k;
}

// The last chain of a closed curve goes on in the first where that begins at the curve's first vertex, and
// both are one part there.
TEST(SharpChain, ChainsCloseOnlyWhereTheyMeet) {
  NetworkCurve curve;
  curve.vertices = {0, 1, 2, 3, 4, 0};
  const auto chains = [](std::size_t begin) {
    std::vector<detail::SharpChain> list(2);
    for (std::size_t k = begin; k <= 2; ++k)
      list[0].corners.push_back(static_cast<int>(k)), list[0].places.push_back(k);
    for (std::size_t k = 3; k <= 5; ++k)
      list[1].corners.push_back(static_cast<int>(k)), list[1].places.push_back(k);
    return list;
  };
  const auto one = [](int) { return 0; };
  std::vector<detail::SharpChain> list = chains(0);
  detail::close_chains(curve, list, one);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].places, (std::vector<std::size_t>{3, 4, 5, 1, 2}));
  list = chains(1);
  detail::close_chains(curve, list, one);
  EXPECT_EQ(list.size(), 2u) << "the first begins behind the seam";
  list = chains(0);
  detail::close_chains(curve, list, [](int corner) { return corner; });
  EXPECT_EQ(list.size(), 2u) << "a sharp curve ends at the seam";
}

}  // namespace
}  // namespace batten
