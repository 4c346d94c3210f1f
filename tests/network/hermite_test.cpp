#include "batten/network/hermite.hpp"

#include "network/sphere_network.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using fixtures::add_polyline;
using fixtures::line;
using fixtures::three_great_circles;

/// A circle with samples at uneven angles (steps between 0.3 and 1.7 of the mean), closed.
CurveNetwork uneven_circle(int n, bool normals, unsigned seed = 1) {
  Random random(seed);
  CurveNetwork network;
  std::vector<double> angles{0};
  for (int i = 1; i <= n; ++i) angles.push_back(angles.back() + random.uniform(0.3, 1.7));
  Points points(n, 3);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * kPi * angles[static_cast<size_t>(i)] / angles.back();
    points.row(i) << std::cos(a), std::sin(a), 0;
  }
  add_polyline(network, points);
  network.curves[0].vertices.push_back(0);
  if (normals) network.normals = points;
  return network;
}

double worst_radius(const HermiteNetwork& splines) {
  double worst = 0;
  for (const HermiteSegment& segment : splines.segments)
    for (int i = 0; i <= 1000; ++i)
      worst = std::max(
          worst, std::abs(segment.position(segment.knots(segment.knots.size() - 1) * i / 1000.0).norm() - 1));
  return worst;
}

// docs/errata.md#s-c-9: with t in [0, 1] on every piece an uneven circle bulges by 11 %; with arc lengths by
// 0.2 %.
TEST(HermiteNetwork, KeepsAnUnevenCircleWithinTwoPerMille) {
  for (const unsigned seed : {1u, 2u, 3u, 4u})
    for (const bool normals : {false, true})
      EXPECT_LT(worst_radius(hermite_network(uneven_circle(16, normals, seed))), 0.002) << seed;
}

// Cubic splines err by the fourth power of the step where the data are smooth.
TEST(HermiteNetwork, ConvergesAtFourthOrderOnThreeGreatCircles) {
  const double coarse = worst_radius(hermite_network(three_great_circles(6))),
               fine = worst_radius(hermite_network(three_great_circles(12)));
  EXPECT_GT(std::log2(coarse / fine), 3.7);
  EXPECT_LT(fine, 1e-5);
}

TEST(HermiteNetwork, InterpolatesAndIsTwiceDifferentiableInside) {
  const HermiteNetwork splines = hermite_network(uneven_circle(20, true));
  ASSERT_EQ(splines.segments.size(), 1u);
  const HermiteSegment& s = splines.segments[0];
  for (Eigen::Index k = 0; k < s.knots.size(); ++k)
    EXPECT_LT((s.position(s.knots(k)).transpose() - s.points.row(k)).norm(), 1e-14);
  for (Eigen::Index k = 1; k + 1 < s.knots.size(); ++k) {
    // from the left: the piece before, continued up to its end
    HermiteSegment before;
    before.knots = Eigen::Vector2d(0, s.knots(k) - s.knots(k - 1));
    before.points = s.points.middleRows(k - 1, 2);
    before.tangents = s.tangents.middleRows(k - 1, 2);
    EXPECT_LT((before.second_derivative(before.knots(1)) - s.second_derivative(s.knots(k))).norm(), 1e-9);
  }
}

// (C.22): e·N = 0 at every node, and a curve that passes through does not turn there.
TEST(HermiteNetwork, TangentsAtNodesArePerpendicularToTheNormalAndPassThrough) {
  for (const NodeTangents kind : {NodeTangents::Free, NodeTangents::EvenAngles}) {
    HermiteOptions options;
    options.node_tangents = kind;
    const CurveNetwork network = three_great_circles(5);
    const HermiteNetwork splines = hermite_network(network, options);
    ASSERT_EQ(splines.segments.size(), 12u);
    for (size_t s = 0; s < 12; ++s) {
      const HermiteSegment& a = splines.segments[s];
      const Eigen::Index last = a.points.rows() - 1;
      EXPECT_LT(std::abs(a.tangents.row(0).dot(network.normals.row(a.vertices.front()))), 1e-14);
      EXPECT_LT(std::abs(a.tangents.row(last).dot(network.normals.row(a.vertices.back()))), 1e-14);
      const HermiteSegment& b = splines.segments[s / 4 * 4 + (s + 1) % 4];  // the next one of the circle
      EXPECT_LT((a.tangents.row(last) - b.tangents.row(0)).norm(), 1e-12);
    }
    EXPECT_LT(worst_radius(splines), 1e-3);
  }
}

// The energy is that of the minimum: no change of a node's tangents within its tangent plane may lower it.
// The gradient is −2 x'' (and +2 x'') at the ends; what a pair shares must cancel.
TEST(HermiteNetwork, NoTangentCanLowerTheEnergy) {
  Random random(3);
  CurveNetwork network = three_great_circles(4);
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v)
    network.positions.row(v) += 0.03 * random.normal3().transpose();
  const HermiteNetwork splines = hermite_network(network);
  for (size_t s = 0; s < splines.segments.size(); ++s) {
    const HermiteSegment &a = splines.segments[s], &b = splines.segments[s / 4 * 4 + (s + 1) % 4];
    const Eigen::Vector3d jump = a.second_derivative(a.knots(a.knots.size() - 1)) - b.second_derivative(0);
    const Eigen::Vector3d normal = network.normals.row(a.vertices.back());
    EXPECT_LT((jump - jump.dot(normal) * normal).norm(), 1e-9 * b.second_derivative(0).norm());
  }
}

// ∫|x''|² of a circle of radius r by arc length is 2π/r; of a straight line 0.
TEST(HermiteNetwork, EnergyIsThatOfTheCurve) {
  EXPECT_NEAR(hermite_network(three_great_circles(32, 2)).energy, 3 * kPi, 1e-4);
  CurveNetwork straight;
  add_polyline(straight, line({0, 0, 0}, {3, 1, 2}, 7));
  EXPECT_LT(hermite_network(straight).energy, 1e-20);
}

// docs/errata.md#s-c-8: at degree 3 with even angles the tangents sum to zero and bend the straight curve of
// a T.
TEST(HermiteNetwork, KeepsTheThroughCurveOfATStraight) {
  for (const NodeTangents kind : {NodeTangents::Free, NodeTangents::EvenAngles}) {
    CurveNetwork network;
    add_polyline(network, line({-2, 0, 0}, {2, 0, 0}, 9));
    add_polyline(network, line({0, 0, 0}, {0.3, 3, 0}, 7));
    network.curves[1].vertices[0] = 4;  // the middle of the first
    network.normals = Points::Zero(network.positions.rows(), 3);
    network.normals.col(2).setOnes();
    HermiteOptions options;
    options.node_tangents = kind;
    const HermiteNetwork splines = hermite_network(network, options);
    ASSERT_EQ(splines.segments.size(), 3u);
    EXPECT_LT(splines.energy, 1e-20);
  }
}

// docs/errata.md#s-c-7: two segments that join the same two nodes, and a loop at one of them.
TEST(HermiteNetwork, TellsParallelSegmentsAndLoopsApart) {
  CurveNetwork network;
  Points lens(16, 3);
  for (int i = 0; i < 16; ++i) lens.row(i) << std::cos(2 * kPi * i / 16), std::sin(2 * kPi * i / 16), 0;
  add_polyline(network, lens);
  network.curves[0].vertices.push_back(0);
  network.tagged_nodes = {0, 8};
  Points loop(15, 3);
  for (int i = 0; i < 15; ++i)
    loop.row(i) << 1 + std::sin(2 * kPi * (i + 1) / 16), 0, 1 - std::cos(2 * kPi * (i + 1) / 16);
  add_polyline(network, loop);
  network.curves[1].vertices.insert(network.curves[1].vertices.begin(), 0);
  network.curves[1].vertices.push_back(0);
  const HermiteNetwork splines = hermite_network(network);
  ASSERT_EQ(splines.segments.size(), 3u);
  double worst = 0;
  for (size_t s = 0; s < 2; ++s)
    for (int i = 0; i <= 100; ++i)
      worst = std::max(
          worst,
          std::abs(splines.segments[s].position(splines.segments[s].knots.tail(1)(0) * i / 100.0).norm() -
                   1));
  EXPECT_LT(worst, 1e-3);
  const HermiteSegment& ring = splines.segments[2];
  for (int i = 0; i <= 100; ++i)
    EXPECT_NEAR((ring.position(ring.knots.tail(1)(0) * i / 100.0) - Eigen::Vector3d(1, 0, 1)).norm(), 1,
                1e-3);
}

// docs/errata.md#s-c-15: the printed recurrence overflows at 540 inner points.
TEST(HermiteNetwork, TakesSegmentsOfAnyLength) {
  const HermiteNetwork splines = hermite_network(three_great_circles(3000));
  EXPECT_LT(worst_radius(splines), 1e-12);
}

TEST(HermiteNetwork, LeavesCornersSharp) {
  CurveNetwork network;
  Points bent(11, 3);
  for (int i = 0; i < 11; ++i) bent.row(i) << std::min(i, 5), std::max(0, i - 5), 0;
  add_polyline(network, bent);
  const HermiteNetwork splines = hermite_network(network);
  ASSERT_EQ(splines.segments.size(), 2u);
  EXPECT_LT(splines.energy, 1e-20);  // two straight lines
}

// A closed curve may begin at a corner; it stays one.
TEST(HermiteNetwork, LeavesTheCornerSharpWhereAClosedCurveBegins) {
  CurveNetwork network;
  Points square(20, 3);
  for (int i = 0; i < 20; ++i) {
    const int k = i % 5;
    square.row(i) << (i < 5    ? k
                      : i < 10 ? 5
                      : i < 15 ? 5 - k
                               : 0),
        (i < 5    ? 0
         : i < 10 ? k
         : i < 15 ? 5
                  : 5 - k),
        0;
  }
  add_polyline(network, square);
  network.curves[0].vertices.push_back(0);
  const HermiteNetwork splines = hermite_network(network);
  EXPECT_EQ(splines.segments.size(), 4u);
  EXPECT_LT(splines.energy, 1e-20);
}

// Two curves that meet at 40 degrees off straight, more than half the corner angle, are two and stay
// straight.
TEST(HermiteNetwork, BendsNoCurvesIntoEachOtherThatMeetAtAnAngle) {
  CurveNetwork network;
  add_polyline(network, line({-2, 0, 0}, {0, 0, 0}, 5));
  add_polyline(network, line({0, 0, 0}, {2 * std::cos(0.7), 2 * std::sin(0.7), 0}, 5));
  network.curves[1].vertices[0] = 4;
  EXPECT_LT(hermite_network(network).energy, 1e-20);
}

// Two half circles whose samples at the joint are 0.1 and then 0.8 radians apart: the directions of both
// halves there are those of the circle, so that they are taken for one curve.
TEST(HermiteNetwork, KnowsTheDirectionOfUnevenSamples) {
  CurveNetwork network;
  const double angles[] = {0.1, 0.9, 1.6, 2.4, kPi};
  Points half(6, 3), other(6, 3);
  half.row(0) << 1, 0, 0;
  for (int k = 0; k < 5; ++k) half.row(k + 1) << std::cos(angles[k]), std::sin(angles[k]), 0;
  other = half;
  other.col(1) *= -1;
  add_polyline(network, half);
  add_polyline(network, other);
  network.curves[1].vertices.front() = 0;
  network.curves[1].vertices.back() = 5;
  const HermiteNetwork splines = hermite_network(network);
  EXPECT_LT((splines.segments[0].tangents.row(0) + splines.segments[1].tangents.row(0)).norm(), 1e-12);
}

// (C.8) at three curves that end: even turns of one frame, which sum to nothing.
TEST(HermiteNetwork, TangentsAtEvenAnglesOfThreeEndsSumToZero) {
  CurveNetwork network;
  for (const double angle : {0.0, 1.8, 4.0}) {
    add_polyline(network, line({0, 0, 0}, {2 * std::cos(angle), 2 * std::sin(angle), 0}, 5));
    network.curves.back().vertices[0] = 0;
  }
  network.normals = Points::Zero(network.positions.rows(), 3);
  network.normals.col(2).setOnes();
  HermiteOptions options;
  options.node_tangents = NodeTangents::EvenAngles;
  const HermiteNetwork splines = hermite_network(network, options);
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (const HermiteSegment& segment : splines.segments) sum += segment.tangents.row(0);
  EXPECT_GT(splines.segments[0].tangents.row(0).norm(), 0.5);
  EXPECT_LT(sum.norm(), 1e-12);
}

TEST(HermiteNetwork, LeavesOutSamplesAtTheSamePlaceAndNamesSegmentsWithoutLength) {
  CurveNetwork network;
  Points points = line({0, 0, 0}, {1, 0, 0}, 5);
  points.row(2) = points.row(1);
  points.row(4) = points.row(3);
  add_polyline(network, points);
  EXPECT_LT(hermite_network(network).energy, 1e-20);
  add_polyline(network, Points::Ones(3, 3));
  try {
    hermite_network(network);
    FAIL();
  } catch (const InvalidInput& problem) {
    EXPECT_NE(std::string(problem.what()).find("curve 1"), std::string::npos);
  }
}

TEST(HermiteNetwork, NamesOptionsOutOfRange) {
  EXPECT_FALSE(HermiteOptions().problem());
  CurveNetwork network;
  add_polyline(network, line({0, 0, 0}, {1, 0, 0}, 5));
  HermiteOptions options;
  options.corner_angle = 0;
  EXPECT_EQ(options.problem(), "corner_angle must be above 0, got 0");
  EXPECT_THROW(hermite_network(network, options), InvalidInput);
  options = {};
  options.parameter_rounds = -1;
  EXPECT_EQ(options.problem(), "parameter_rounds must be at least 0, got -1");
  EXPECT_THROW(hermite_network(network, options), InvalidInput);
}

}  // namespace
}  // namespace batten
