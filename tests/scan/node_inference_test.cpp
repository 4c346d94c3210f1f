#include "batten/scan/node_inference.hpp"

#include "scan/scan_fixtures.hpp"

#include <map>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

Scan without_numbers(Scan scan) {
  for (ScanCurve& curve : scan.curves) std::fill(curve.node_ids.begin(), curve.node_ids.end(), kNoNodeNumber);
  return scan;
}

/// Whether both number the same visits alike, up to the names.
bool same_nodes(const Scan& a, const Scan& b) {
  std::map<int, int> there, back;
  for (size_t c = 0; c < a.curves.size(); ++c) {
    if (a.curves[c].node_readings != b.curves[c].node_readings) return false;
    for (size_t j = 0; j < a.curves[c].node_ids.size(); ++j) {
      const int x = a.curves[c].node_ids[j], y = b.curves[c].node_ids[j];
      if (there.emplace(x, y).first->second != y || back.emplace(y, x).first->second != x) return false;
    }
  }
  return true;
}

TEST(InferNodes, FindsAllNumbersOfMarkedStays) {
  for (const AnalyticShape shape :
       {AnalyticShape::Sphere, AnalyticShape::Saddle, AnalyticShape::Waves, AnalyticShape::Cone}) {
    const Scan scan = simulate_scan(trace_shape(shape), {}).scan;
    const NodeInference found = infer_nodes(without_numbers(scan));
    EXPECT_TRUE(found.is_sure()) << found.doubts.front();
    EXPECT_TRUE(same_nodes(found.scan, scan)) << static_cast<int>(shape);
  }
}

TEST(InferNodes, FindsThemInNoiseWithTheirEvidence) {
  SimulateOptions device = test::noisy_device(3);
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere6), device).scan;
  const NodeInference found = infer_nodes(without_numbers(scan));
  ASSERT_TRUE(found.is_sure()) << found.doubts.front();
  EXPECT_TRUE(same_nodes(found.scan, scan));
  EXPECT_GT(found.margin, 6);
  for (const InferredNode& node : found.nodes) {
    EXPECT_EQ(node.visits.size(), 2U);
    for (const NodeVisit& visit : node.visits) {
      EXPECT_GT(visit.margin, 6);
      EXPECT_LT(visit.normal_angle, radians(6));
      EXPECT_LT(visit.misfit, 0.05);
    }
  }
}

TEST(InferNodes, TakesRestsForStaysWhereNothingIsMarkedAndKeepsGivenNumbers) {
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), {}).scan;
  Scan bare = scan;
  for (ScanCurve& curve : bare.curves) curve.node_readings.clear(), curve.node_ids.clear();
  EXPECT_TRUE(same_nodes(infer_nodes(bare).scan, scan));
  Scan partly = without_numbers(scan);
  partly.curves[1].node_ids[1] = 5;
  const NodeInference found = infer_nodes(partly);
  EXPECT_EQ(found.scan.curves[1].node_ids[1], 5);
  EXPECT_TRUE(same_nodes(found.scan, scan));
}

/// Straight lines on a plane, with a stay at every whole number.
ScanCurve straight_line(const Eigen::RowVector3d& direction, int length) {
  ScanCurve curve;
  const int n = 10 * length + 1;
  curve.distances = Eigen::VectorXd::LinSpaced(n, 0, length);
  curve.tangents = direction.replicate(n, 1);
  curve.normals = Eigen::RowVector3d(0, 0, 1).replicate(n, 1);
  for (int i = 0; i <= length; ++i) {
    curve.node_readings.push_back(10 * i);
    curve.node_ids.push_back(kNoNodeNumber);
  }
  return curve;
}

// Two lines on a plane cross at one of nine pairs of stays, and nothing tells at which.
TEST(InferNodes, IsNotSureOfWhatNothingTells) {
  Scan scan;
  scan.curves = {straight_line({1, 0, 0}, 2), straight_line({0, 1, 0}, 2)};
  const NodeInference found = infer_nodes(scan);
  EXPECT_FALSE(found.is_sure());
  EXPECT_LT(found.margin, 1);
}

TEST(InferNodes, SaysWhichStaysFitNothing) {
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), {}).scan;
  Scan more = without_numbers(scan);
  ScanCurve& curve = more.curves[0];  // between its first two nodes
  const int reading = (curve.node_readings[0] + curve.node_readings[1]) / 2;
  curve.node_readings.insert(curve.node_readings.begin() + 1, reading);
  curve.node_ids.push_back(kNoNodeNumber);
  const NodeInference found = infer_nodes(more);
  ASSERT_EQ(found.doubts.size(), 1U);
  EXPECT_NE(found.doubts.front().find("reading " + std::to_string(reading + 1)), std::string::npos)
      << found.doubts.front();
  EXPECT_THROW(infer_nodes(Scan{}), InvalidInput);
}

}  // namespace
}  // namespace batten
