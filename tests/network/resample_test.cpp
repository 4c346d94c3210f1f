#include "batten/network/resample.hpp"

#include "network/sphere_network.hpp"

#include <cmath>
#include <functional>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using fixtures::add_polyline;
using fixtures::line;
using fixtures::three_great_circles;

// Points and normals of a sphere are known everywhere; cubic interpolation errs at fourth order.
TEST(Resampled, PutsPointsAndNormalsOfASphereBackOnIt) {
  double errors[2], normal_errors[2];
  for (const int k : {0, 1}) {
    const CurveNetwork network = resampled(three_great_circles(6 << k), 0.031);
    errors[k] = (network.positions.rowwise().norm().array() - 1).abs().maxCoeff();
    normal_errors[k] =
        (network.normals - network.positions.rowwise().normalized()).rowwise().norm().maxCoeff();
    EXPECT_LT((network.normals.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-12);
  }
  EXPECT_GT(std::log2(errors[0] / errors[1]), 3.7);
  EXPECT_GT(std::log2(normal_errors[0] / normal_errors[1]), 2.7);
  EXPECT_LT(normal_errors[1], 1e-4);
}

// A quarter of a great circle has the length π/2; equal arcs have equal chords.
TEST(Resampled, StepsEvenlyByArcLengthAndKeepsNodes) {
  for (const double scale : {1.0, 1e-3, 1e3}) {
    const CurveNetwork before = three_great_circles(9, scale), after = resampled(before, 0.1 * scale);
    const NetworkTopology topology = network_topology(after);
    ASSERT_EQ(topology.nodes.size(), 6u);
    ASSERT_EQ(topology.segments.size(), 12u);
    for (const NetworkSegment& segment : topology.segments) {
      ASSERT_EQ(segment.vertices.size(), 17u);  // π/2 / 0.1 = 15.7, so 16 steps
      for (size_t k = 1; k < 17; ++k)
        EXPECT_NEAR(
            (after.positions.row(segment.vertices[k]) - after.positions.row(segment.vertices[k - 1])).norm(),
            2 * scale * std::sin(kPi / 64), 2e-6 * scale);
    }
    for (int node = 0; node < 6; ++node) {
      bool found = false;
      for (Eigen::Index v = 0; v < after.positions.rows(); ++v)
        found = found || after.positions.row(v) == before.positions.row(node);
      EXPECT_TRUE(found);
    }
  }
}

TEST(Resampled, KeepsNamesFlagsAndOrder) {
  CurveNetwork network = three_great_circles(6);
  network.curves[1].name = "belt";
  network.curves[1].boundary = true;
  network.unit = "mm";
  network.tagged_nodes = {0};
  const CurveNetwork after = resampled(network, 0.05);
  ASSERT_EQ(after.curves.size(), 3u);
  EXPECT_EQ(after.curves[1].name, "belt");
  EXPECT_TRUE(after.curves[1].boundary);
  EXPECT_EQ(after.unit, "mm");
  ASSERT_EQ(after.tagged_nodes.size(), 1u);
  EXPECT_EQ(after.positions.row(after.tagged_nodes[0]), network.positions.row(0));
  for (const NetworkCurve& curve : after.curves) EXPECT_TRUE(curve.closed());
}

// The normals of a tilted plane stay, those of uneven circles stay perpendicular to the tangent.
TEST(Resampled, NormalsArePerpendicularToTheCurve) {
  Random random(6);
  CurveNetwork network = three_great_circles(12);
  for (Eigen::Index v = 6; v < network.normals.rows(); ++v)
    network.normals.row(v) = (network.normals.row(v) + 0.05 * random.normal3().transpose()).normalized();
  const CurveNetwork after = resampled(network, 0.02);
  for (const NetworkSegment& segment : network_topology(after).segments)
    for (size_t k = 1; k + 1 < segment.vertices.size(); ++k) {
      const Eigen::RowVector3d tangent =
          (after.positions.row(segment.vertices[k + 1]) - after.positions.row(segment.vertices[k - 1]))
              .normalized();
      EXPECT_LT(std::abs(tangent.dot(after.normals.row(segment.vertices[k]))), 1e-3);
    }
}

// Rotated, moved and scaled input gives rotated, moved and scaled output.
TEST(Resampled, CommutesWithSimilarity) {
  const CurveNetwork network = three_great_circles(7);
  const CurveNetwork expected = resampled(network, 0.06);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, -2, 0.5).normalized()).matrix();
  for (const double scale : {1e-3, 1e3}) {
    CurveNetwork moved = network;
    moved.positions =
        (scale * (network.positions * turn.transpose())).rowwise() + scale * Eigen::RowVector3d(3, 4, -5);
    moved.normals = network.normals * turn.transpose();
    const CurveNetwork after = resampled(moved, 0.06 * scale);
    ASSERT_EQ(after.positions.rows(), expected.positions.rows());
    const Points back = ((after.positions.rowwise() - scale * Eigen::RowVector3d(3, 4, -5)) * turn) / scale;
    EXPECT_LT((back - expected.positions).rowwise().norm().maxCoeff(), 1e-9);
    EXPECT_LT((after.normals * turn - expected.normals).rowwise().norm().maxCoeff(), 1e-8);
  }
}

// On an ellipse of few samples no piece has an even speed: steps are even by length all the same.
TEST(Resampled, StepsEvenlyWhereThePiecesDoNot) {
  CurveNetwork network;
  Points points(14, 3);
  for (int i = 0; i < 14; ++i) points.row(i) << 2 * std::cos(2 * kPi * i / 14), std::sin(2 * kPi * i / 14), 0;
  add_polyline(network, points);
  network.curves[0].vertices.push_back(0);
  const CurveNetwork after = resampled(network, 0.002);
  const std::vector<int>& walk = after.curves[0].vertices;
  ASSERT_GT(walk.size(), 4800u);
  double least = 1, most = 0;
  for (size_t k = 1; k < walk.size(); ++k) {
    const double chord = (after.positions.row(walk[k]) - after.positions.row(walk[k - 1])).norm();
    least = std::min(least, chord);
    most = std::max(most, chord);
  }
  EXPECT_LT(most / least - 1, 1e-4);
}

/// A straight line along x with n + 1 samples, and normals at an angle about it.
CurveNetwork twisted_line(int n, const std::function<double(double)>& angle) {
  CurveNetwork network;
  add_polyline(network, line({0, 0, 0}, {1, 0, 0}, n + 1));
  network.normals.resize(n + 1, 3);
  for (int k = 0; k <= n; ++k) {
    const double a = angle(static_cast<double>(k) / n);
    network.normals.row(k) << 0, std::cos(a), std::sin(a);
  }
  return network;
}

// Normals that turn faster and faster: the error falls faster than the square of the step, at the ends too.
TEST(Resampled, NormalsFollowATwistUpToTheEnds) {
  const auto angle = [](double x) { return x * x; };
  double worst[2] = {0, 0};
  for (const int k : {0, 1}) {
    const CurveNetwork after = resampled(twisted_line(8 << k, angle), 0.002);
    for (Eigen::Index v = 0; v < after.positions.rows(); ++v) {
      const double a = angle(after.positions(v, 0));
      worst[k] =
          std::max(worst[k], (after.normals.row(v) - Eigen::RowVector3d(0, std::cos(a), std::sin(a))).norm());
    }
  }
  EXPECT_GT(std::log2(worst[0] / worst[1]), 2.4) << worst[0] << " " << worst[1];
}

// Between normals more than a right angle apart there is no telling which way they turn: the nearer counts.
TEST(Resampled, TakesTheNearerOfNormalsThatContradictEachOther) {
  const CurveNetwork network = twisted_line(1, [](double x) { return x * 2 * kPi / 3; });
  const CurveNetwork after = resampled(network, 0.05);
  ASSERT_EQ(after.positions.rows(), 21);
  for (Eigen::Index v = 0; v < 21; ++v) {
    if (std::abs(after.positions(v, 0) - 0.5) < 1e-6) continue;
    EXPECT_LT((after.normals.row(v) - network.normals.row(after.positions(v, 0) < 0.5 ? 0 : 1)).norm(),
              1e-12);
  }
}

// Normals between the nodes that lean along the curve by 60 degrees are brought back.
TEST(Resampled, NormalsThatLeanFarAreMadeSquareToTheCurve) {
  CurveNetwork network = twisted_line(4, [](double) { return 0.0; });
  for (int k = 1; k < 4; ++k) network.normals.row(k) << std::sqrt(0.75), 0.5, 0;
  const CurveNetwork after = resampled(network, 0.05);
  for (Eigen::Index v = 0; v < after.positions.rows(); ++v)
    EXPECT_LT((after.normals.row(v) - Eigen::RowVector3d(0, 1, 0)).norm(), 1e-12) << v;
}

TEST(Resampled, TakesALongStepAsTheNodesAlone) {
  const CurveNetwork after = resampled(three_great_circles(6), 100);
  EXPECT_EQ(after.positions.rows(), 6);
  CurveNetwork ring;
  Points points(12, 3);
  for (int i = 0; i < 12; ++i) points.row(i) << std::cos(2 * kPi * i / 12), std::sin(2 * kPi * i / 12), 0;
  add_polyline(ring, points);
  ring.curves[0].vertices.push_back(0);
  EXPECT_EQ(resampled(ring, 100).positions.rows(), 3);  // a closed curve keeps three samples
}

TEST(Resampled, RefusesStepsThatMakeNoSense) {
  const CurveNetwork network = three_great_circles(6);
  for (const double bad : {0.0, -0.1, std::nan(""), 1e-12})
    EXPECT_THROW(resampled(network, bad), InvalidInput);
}

}  // namespace
}  // namespace batten
