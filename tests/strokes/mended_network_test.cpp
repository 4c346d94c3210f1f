#include "batten/strokes/mended_network.hpp"

#include "network/sharp_networks.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

/// Every curve with vertices of its own.
CurveNetwork taken_apart(const CurveNetwork& network) {
  CurveNetwork result;
  Eigen::Index n = 0;
  for (const NetworkCurve& curve : network.curves) n += static_cast<Eigen::Index>(curve.vertices.size());
  result.positions.resize(n, 3);
  result.normals.resize(n, 3);
  int next = 0;
  for (NetworkCurve curve : network.curves) {
    for (int& v : curve.vertices) {
      result.positions.row(next) = network.positions.row(v);
      result.normals.row(next) = network.normals.row(v);
      v = next++;
    }
    result.curves.push_back(curve);
  }
  return result;
}

TEST(MendedNetwork, WhatMeetsComesBackBitForBit) {
  for (const CurveNetwork& network : {samples::octahedral_sphere(6), samples::lens(8, true)}) {
    const MendedNetwork mended = mended_network(network);
    EXPECT_FALSE(mended.changed);
    EXPECT_TRUE(mended.warnings.empty());
    EXPECT_EQ(mended.network.positions, network.positions);
    ASSERT_EQ(mended.network.curves.size(), network.curves.size());
    EXPECT_EQ(mended.network.curves[0].vertices, network.curves[0].vertices);
  }
}

TEST(MendedNetwork, CurvesWithVerticesOfTheirOwnAreJoined) {
  const CurveNetwork whole = samples::octahedral_sphere(6);
  const MendedNetwork mended = mended_network(taken_apart(whole));
  EXPECT_TRUE(mended.changed);
  EXPECT_EQ(mended.network.curves.size(), 12u);
  EXPECT_EQ(mended.n_left_out, 0);
  EXPECT_EQ(find_cycles(mended.network).cycles.size(), 8u);
  ASSERT_EQ(mended.warnings.size(), 1u);
  EXPECT_NE(mended.warnings[0].find("welded"), std::string::npos);
}

TEST(MendedNetwork, CrossingsBetweenSamplesGetANodeAndFreeEndsAreLeftOut) {
  // Two great circles turned so that no samples fall together, a third one that is whole, and a loose
  // quarter.
  samples::NetworkBuilder builder;
  const auto outwards = [](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p; };
  for (int axis = 0; axis < 3; ++axis)
    builder.curve(
        62, false,
        [=](double t) {
          const double angle = 2 * kPi * t + 0.02 + 0.013 * axis;
          Eigen::Vector3d p = Eigen::Vector3d::Zero();
          p[(axis + 1) % 3] = std::cos(angle);
          p[(axis + 2) % 3] = std::sin(angle);
          return p;
        },
        outwards);
  builder.curve(
      10, false,
      [](double t) -> Eigen::Vector3d {
        return Eigen::Vector3d(0.1 + 0.5 * t, 0.3, 0.4 + 0.1 * t).normalized();
      },
      outwards);
  const MendedNetwork mended = mended_network(builder.build());
  EXPECT_EQ(find_cycles(mended.network).cycles.size(), 8u);
  EXPECT_EQ(mended.n_left_out, 1);
  EXPECT_LE(mended.weld_tolerance, 1e-3);
  for (Eigen::Index v = 0; v < mended.network.normals.rows(); ++v)
    EXPECT_NEAR(mended.network.normals.row(v).norm(), 1, 1e-12);
}

TEST(MendedNetwork, FacesDrawnOneByOneMeetInSharpEdges) {
  // Six squares, each with its own outline and normal, as a CAD program writes a box.
  CurveNetwork faces;
  faces.positions.resize(6 * 16, 3);
  faces.normals.resize(6 * 16, 3);
  for (int face = 0; face < 6; ++face) {
    const int axis = face % 3;
    const double side = face < 3 ? 1 : -1;
    NetworkCurve outline;
    for (int k = 0; k < 16; ++k) {
      const double t = k % 4 / 2.0 - 1;
      const double u[4] = {t, 1, -t, -1}, w[4] = {-1, t, 1, -t};
      Eigen::Vector3d p = Eigen::Vector3d::Zero(), normal = side * Eigen::Vector3d::Unit(axis);
      p[axis] = side;
      p[(axis + 1) % 3] = side * u[k / 4];
      p[(axis + 2) % 3] = w[k / 4];
      const int v = 16 * face + k;
      faces.positions.row(v) = p;
      faces.normals.row(v) = normal;
      outline.vertices.push_back(v);
    }
    outline.vertices.push_back(16 * face);
    faces.curves.push_back(outline);
  }
  const MendedNetwork mended = mended_network(faces);
  EXPECT_EQ(mended.n_doubled, 12);
  EXPECT_EQ(mended.n_sharp, 12);
  ASSERT_EQ(mended.network.curves.size(), 12u);
  for (const NetworkCurve& curve : mended.network.curves) EXPECT_TRUE(curve.sharp);
  EXPECT_EQ(find_cycles(mended.network).cycles.size(), 6u);
}

TEST(MendedNetwork, RefusesInWords) {
  CurveNetwork network = samples::octahedral_sphere(4);
  NetworkMendingOptions options;
  options.weld_tolerance = -1;
  EXPECT_THROW(mended_network(network, options), InvalidInput);
  network.normals.resize(0, 3);
  EXPECT_THROW(mended_network(network), InvalidInput);
}

}  // namespace
}  // namespace batten
