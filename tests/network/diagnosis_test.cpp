#include "batten/network/diagnosis.hpp"

#include "network/sphere_network.hpp"

#include <algorithm>
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

std::vector<NetworkFinding> of_kind(const std::vector<NetworkFinding>& findings, NetworkDefect defect) {
  std::vector<NetworkFinding> some;
  for (const NetworkFinding& finding : findings)
    if (finding.defect == defect) some.push_back(finding);
  return some;
}

std::string all_sentences(const std::vector<NetworkFinding>& findings) {
  std::string text;
  for (const NetworkFinding& finding : findings) text += finding.sentence + "\n";
  return text;
}

/// A square frame of side 10, tagged, without normals: everything else is added to it by the tests.
CurveNetwork frame() {
  CurveNetwork network;
  network.positions.resize(40, 3);
  NetworkCurve rim{"rim", true, {}};
  for (int i = 0; i < 40; ++i) {
    const int side = i / 10, k = i % 10;
    network.positions.row(i) << (side == 0   ? k
                                 : side == 1 ? 10
                                 : side == 2 ? 10 - k
                                             : 0),
        (side == 0   ? 0
         : side == 1 ? k
         : side == 2 ? 10
                     : 10 - k),
        0;
    rim.vertices.push_back(i);
  }
  rim.vertices.push_back(0);
  network.curves.push_back(rim);
  return network;
}

TEST(DiagnoseNetwork, FindsNothingInASoundNetworkAtAnyScale) {
  for (const double scale : {1.0, 1e-3, 1e3}) {
    const auto findings = diagnose_network(three_great_circles(12, scale));
    EXPECT_TRUE(findings.empty()) << all_sentences(findings);
  }
  // At 45 degrees a step, normals are square to the chord over a sample though not to the two beside it.
  const auto coarse = diagnose_network(three_great_circles(2));
  EXPECT_TRUE(coarse.empty()) << all_sentences(coarse);
  EXPECT_TRUE(diagnose_network(frame()).empty());
  EXPECT_TRUE(diagnose_network(CurveNetwork()).empty());
}

// Distances are by construction: the diameter is 14.14, so 0.003 of it is 0.042 and 0.03 of it is 0.42.
TEST(DiagnoseNetwork, TellsHowFarAnEndStopsFromWhat) {
  CurveNetwork network = frame();
  add_polyline(network, line({0, 5, 0}, {9.7, 5, 0}, 30));  // begins on a vertex's place, stops 0.3 short
  add_polyline(network, line({5.5, 10.02, 0}, {5.5, 7, 0},
                             10));  // begins 0.02 off the frame, ends 2 away from the other
  const auto findings = diagnose_network(network);
  const auto near_misses = of_kind(findings, NetworkDefect::NearMiss);
  ASSERT_EQ(near_misses.size(), 1u) << all_sentences(findings);
  EXPECT_EQ(near_misses[0].curve, 1);
  EXPECT_EQ(near_misses[0].other_curve, 0);
  EXPECT_NEAR(near_misses[0].distance, 0.3, 1e-12);
  EXPECT_NE(near_misses[0].sentence.find("rim"), std::string::npos);
  const auto junctions = of_kind(findings, NetworkDefect::TJunction);
  ASSERT_EQ(junctions.size(), 2u) << all_sentences(findings);
  EXPECT_NEAR(junctions[0].distance, 0, 1e-12);
  EXPECT_NEAR(junctions[1].distance, 0.02, 1e-12);
  const auto dangling = of_kind(findings, NetworkDefect::DanglingEnd);
  ASSERT_EQ(dangling.size(), 1u) << all_sentences(findings);
  EXPECT_NEAR(dangling[0].distance, 2, 1e-12);
  EXPECT_EQ(dangling[0].other_curve, 1);
  EXPECT_EQ(of_kind(findings, NetworkDefect::SeparateParts).size(), 2u);
  EXPECT_TRUE(of_kind(findings, NetworkDefect::Crossing).empty()) << all_sentences(findings);
}

TEST(DiagnoseNetwork, FindsCrossingsOnceAndWhere) {
  CurveNetwork network = frame();
  add_polyline(network, line({1, 3, 0}, {9, 3, 0}, 23));
  add_polyline(network, line({4, 1, 0.01}, {4, 9, 0.01}, 31));
  const auto crossings = of_kind(diagnose_network(network), NetworkDefect::Crossing);
  ASSERT_EQ(crossings.size(), 1u);
  EXPECT_EQ(crossings[0].curve, 1);
  EXPECT_EQ(crossings[0].other_curve, 2);
  EXPECT_LT((crossings[0].position - Eigen::Vector3d(4, 3, 0)).norm(), 1e-9);
  EXPECT_NEAR(crossings[0].distance, 0.01, 1e-12);
  EXPECT_EQ(crossings[0].vertex, 40 + 8);  // a step of the first line is 8/22: 8 steps are 2.91, 9 are 3.27
}

// However coarsely straight lines are sampled: where they cross they do not run along each other.
TEST(DiagnoseNetwork, LongEdgesThatCrossAreNoOverlap) {
  CurveNetwork network = frame();
  add_polyline(network, line({1, 3, 0}, {9, 3, 0}, 2));
  add_polyline(network, line({4, 1, 0.01}, {4, 9, 0.01}, 2));
  const auto findings = diagnose_network(network);
  EXPECT_EQ(of_kind(findings, NetworkDefect::Crossing).size(), 1u) << all_sentences(findings);
  EXPECT_TRUE(of_kind(findings, NetworkDefect::Overlap).empty()) << all_sentences(findings);
}

// Sampling far below the tolerance must not change what is found, nor take quadratic time.
TEST(DiagnoseNetwork, DoesNotDependOnTheSampling) {
  for (const int n : {20, 200, 100000}) {
    CurveNetwork network = frame();
    add_polyline(network, line({1, 3, 0}, {9, 3, 0}, n));
    add_polyline(network, line({4, 1, 0.01}, {4, 9, 0.01}, n + 7));
    const auto crossings = of_kind(diagnose_network(network), NetworkDefect::Crossing);
    ASSERT_EQ(crossings.size(), 1u) << n;
    EXPECT_LT((crossings[0].position - Eigen::Vector3d(4, 3, 0)).norm(), 1e-6) << n;
  }
}

TEST(DiagnoseNetwork, FindsDuplicatesAndOverlaps) {
  CurveNetwork network = frame();
  add_polyline(network, line({1, 5, 0}, {9, 5, 0}, 40));
  add_polyline(network, line({1, 5.01, 0}, {9, 5.01, 0}, 33));
  add_polyline(network, line({5, 4.99, 0}, {9.5, 4.99, 0.0}, 20));
  const auto findings = diagnose_network(network);
  const auto duplicates = of_kind(findings, NetworkDefect::DuplicateCurve);
  ASSERT_EQ(duplicates.size(), 1u) << all_sentences(findings);
  EXPECT_EQ(duplicates[0].curve, 1);
  EXPECT_EQ(duplicates[0].other_curve, 2);
  const auto overlaps = of_kind(findings, NetworkDefect::Overlap);
  ASSERT_EQ(overlaps.size(), 2u) << all_sentences(findings);
  EXPECT_NEAR(overlaps[0].distance, 4, 0.05);
}

// A short curve that lies on a long one is all of itself and not all of the other.
TEST(DiagnoseNetwork, ShortCurveOnALongOneIsNoDuplicateWhicheverComesFirst) {
  for (const bool short_first : {true, false}) {
    CurveNetwork network = frame();
    for (const bool is_short : {short_first, !short_first})
      add_polyline(network, is_short ? line({4, 5.01, 0}, {6, 5.01, 0}, 20) : line({1, 5, 0}, {9, 5, 0}, 40));
    const auto findings = diagnose_network(network);
    EXPECT_TRUE(of_kind(findings, NetworkDefect::DuplicateCurve).empty()) << all_sentences(findings);
    const auto overlaps = of_kind(findings, NetworkDefect::Overlap);
    ASSERT_EQ(overlaps.size(), 1u);
    EXPECT_NEAR(overlaps[0].distance, 2, 0.1);
  }
}

TEST(DiagnoseNetwork, FindsACurveThatCrossesItself) {
  CurveNetwork network;
  Points eight(81, 3);
  for (int i = 0; i < 81; ++i) {
    const double t = 2 * kPi * (i + 0.5) / 81;  // Gerono's figure eight, without a sample at the crossing
    eight.row(i) << std::cos(t), std::sin(t) * std::cos(t), 0;
  }
  const int c = add_polyline(network, eight);
  network.curves[0].vertices.push_back(network.curves[0].vertices.front());
  EXPECT_EQ(c, 0);
  const auto findings = diagnose_network(network);
  const auto crossings = of_kind(findings, NetworkDefect::SelfCrossing);
  ASSERT_EQ(crossings.size(), 1u) << all_sentences(findings);
  EXPECT_LT(crossings[0].position.norm(), 0.01);
}

TEST(DiagnoseNetwork, FindsFlippedAndTiltedNormals) {
  CurveNetwork network = three_great_circles(12);
  const std::vector<int>& circle = network.curves[1].vertices;
  for (int k = 14; k < 20; ++k) network.normals.row(circle[static_cast<size_t>(k)]) *= -1;
  const int tilted = network.curves[2].vertices[3];
  const Eigen::RowVector3d tangent = network.positions.row(network.curves[2].vertices[4]) -
                                     network.positions.row(network.curves[2].vertices[2]);
  network.normals.row(tilted) =
      (network.normals.row(tilted) + tangent.normalized()).normalized();  // 45 degrees
  const auto findings = diagnose_network(network);
  const auto flipped = of_kind(findings, NetworkDefect::FlippedNormals);
  ASSERT_EQ(flipped.size(), 1u) << all_sentences(findings);
  EXPECT_EQ(flipped[0].curve, 1);
  EXPECT_EQ(flipped[0].vertex, circle[14]);
  EXPECT_NE(flipped[0].sentence.find("6 of the"), std::string::npos);
  const auto tilts = of_kind(findings, NetworkDefect::TiltedNormal);
  ASSERT_EQ(tilts.size(), 1u) << all_sentences(findings);
  EXPECT_EQ(tilts[0].vertex, tilted);
  EXPECT_NEAR(tilts[0].distance, kPi / 4, 0.1);
}

TEST(DiagnoseNetwork, FindsABorderThatDoesNotClose) {
  CurveNetwork network = frame();
  network.curves[0].vertices.pop_back();
  const auto open = of_kind(diagnose_network(network), NetworkDefect::OpenBoundary);
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open[0].vertex, 0);
  EXPECT_EQ(open[1].vertex, 39);
}

// Three tagged edges at one vertex: whichever two are the border, the third leads nowhere.
TEST(DiagnoseNetwork, FindsABorderThatBranches) {
  CurveNetwork network = frame();
  const int branch = add_polyline(network, line({4, 0, 0}, {4, 10, 0}, 11), true);
  network.curves[static_cast<size_t>(branch)].vertices.front() = 4;
  network.curves[static_cast<size_t>(branch)].vertices.back() = 26;
  const auto open = of_kind(diagnose_network(network), NetworkDefect::OpenBoundary);
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open[0].vertex, 4);
  EXPECT_EQ(open[1].vertex, 26);
  EXPECT_NE(open[0].sentence.find("3 tagged edges meet"), std::string::npos) << open[0].sentence;
}

TEST(DiagnoseNetwork, GivesSeparatePartsTheirDistance) {
  CurveNetwork network = three_great_circles(12);
  const auto before = static_cast<int>(network.positions.rows());
  Points ring(24, 3);
  for (int i = 0; i < 24; ++i)
    ring.row(i) << 3 + 0.5 * std::cos(2 * kPi * i / 24), 0.5 * std::sin(2 * kPi * i / 24), 0;
  add_polyline(network, ring);
  network.curves.back().vertices.push_back(before);
  network.normals.resize(0, 3);
  const auto parts = of_kind(diagnose_network(network), NetworkDefect::SeparateParts);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].curve, 3);
  EXPECT_NEAR(parts[0].distance, 1.5, 1e-12);
}

// Findings refer to places: moved, turned and scaled networks have the same ones.
TEST(DiagnoseNetwork, IsInvariantUnderSimilarity) {
  CurveNetwork network = frame();
  add_polyline(network, line({1, 3, 0}, {9, 3, 0}, 23));
  add_polyline(network, line({4, 1, 0.01}, {4, 9.8, 0.01}, 31));
  const auto expected = diagnose_network(network);
  ASSERT_FALSE(expected.empty());
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).matrix();
  for (const double scale : {1e-3, 1e3}) {
    CurveNetwork moved = network;
    for (Eigen::Index v = 0; v < moved.positions.rows(); ++v)
      moved.positions.row(v) =
          scale * (turn * network.positions.row(v).transpose() + Eigen::Vector3d(5, -2, 7)).transpose();
    const auto found = diagnose_network(moved);
    ASSERT_EQ(found.size(), expected.size()) << all_sentences(found);
    for (size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].defect, expected[k].defect);
      EXPECT_EQ(found[k].curve, expected[k].curve);
      EXPECT_NEAR(found[k].distance, scale * expected[k].distance, 1e-9 * scale);
    }
  }
}

TEST(DiagnoseNetwork, NamesOptionsOutOfRange) {
  EXPECT_FALSE(DiagnosisOptions().problem());
  DiagnosisOptions options;
  options.meeting_distance = -0.25;
  EXPECT_EQ(options.problem(), "meeting_distance must be finite and at least 0, got -0.25");
  EXPECT_THROW(diagnose_network(frame(), options), InvalidInput);
  options = {};
  options.near_miss_distance = INFINITY;
  EXPECT_EQ(options.problem(), "near_miss_distance must be finite and at least 0, got inf");
  options = {};
  options.max_normal_tilt = -1;
  EXPECT_EQ(options.problem(), "max_normal_tilt must be at least 0, got -1");
}

}  // namespace
}  // namespace batten
