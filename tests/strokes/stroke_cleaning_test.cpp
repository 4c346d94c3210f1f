#include "batten/strokes/stroke_cleaning.hpp"

#include "network/sphere_network.hpp"
#include "network/torus_grid.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {
namespace {

/// Points of the circle of radius r about the origin in the xy plane.
Points arc(double begin, double end, int n, double r = 1, double z = 0) {
  Points points(n, 3);
  for (int i = 0; i < n; ++i) {
    const double angle = begin + (end - begin) * i / (n - 1);
    points.row(i) << r * std::cos(angle), r * std::sin(angle), z;
  }
  return points;
}

int count(const CleanedStrokes& sketch, NetworkDefect defect) {
  return count_findings(sketch.findings, defect);
}

/// The three great circles with vertices of their own, each moved along its axis by `miss` and no normals.
CurveNetwork missing_circles(double miss, int m = 16) {
  CurveNetwork network = fixtures::unwelded(fixtures::three_great_circles(m));
  for (size_t c = 0; c < 3; ++c)
    for (size_t k = 0; k + 1 < network.curves[c].vertices.size(); ++k)
      network.positions(network.curves[c].vertices[k], static_cast<Eigen::Index>(c)) += miss;
  return network;
}

TEST(JoinedCurves, PassThroughVerticesOfTwoCurves) {
  CurveNetwork network;
  network.positions = arc(0, kPi, 9);
  // 0–3, 8–5 (against the walk), 3–5: one curve of nine vertices.
  network.curves = {{"a", false, {0, 1, 2, 3}}, {"b", false, {8, 7, 6, 5}}, {"c", false, {3, 4, 5}}};
  CurveNetwork joined = joined_curves(network);
  ASSERT_EQ(joined.curves.size(), 1u);
  EXPECT_EQ(joined.curves[0].vertices, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(joined.curves[0].name, "a");
  network.tagged_nodes = {3};
  EXPECT_EQ(joined_curves(network).curves.size(), 2u);
  network.tagged_nodes.clear();
  network.curves[2].boundary = true;
  EXPECT_EQ(joined_curves(network).curves.size(), 3u);
}

// A circle in three pieces is one closed curve; a curve through a crossing stays one.
TEST(JoinedCurves, CloseAndKeepCrossings) {
  CurveNetwork network = fixtures::three_great_circles(4);
  const std::vector<int> whole = network.curves[0].vertices;
  network.curves[0].vertices = {whole.begin(), whole.begin() + 7};
  network.curves.push_back({"", false, {whole.begin() + 6, whole.end()}});
  const CurveNetwork joined = joined_curves(network);
  ASSERT_EQ(joined.curves.size(), 3u);
  for (const NetworkCurve& curve : joined.curves) {
    EXPECT_TRUE(curve.closed());
    EXPECT_EQ(curve.vertices.size(), 17u);
  }
}

// Three circles that miss each other by 0.2 % of the radius (0.06 % of the diameter) make an octahedron: six
// nodes, twelve segments. Nothing moves by more than the miss.
TEST(CleanSketch, WeldsCrossings) {
  const CurveNetwork sketch = missing_circles(0.002);
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_EQ(cleaned.n_strokes, 3);
  const NetworkTopology topology = network_topology(cleaned.network);
  EXPECT_EQ(topology.nodes.size(), 6u);
  EXPECT_EQ(topology.segments.size(), 12u);
  EXPECT_EQ(topology.n_components, 1);
  EXPECT_EQ(count(cleaned, NetworkDefect::Crossing), 6);
  EXPECT_EQ(cleaned.n_left_out, 0);
  for (Eigen::Index v = 0; v < cleaned.network.positions.rows(); ++v)
    EXPECT_NEAR(cleaned.network.positions.row(v).norm(), 1, 0.003);
}

// An arc drawn again 0.2 % of the diameter beside a circle adds nothing.
TEST(CleanSketch, LeavesOutWhatIsDrawnTwice) {
  CurveNetwork sketch = missing_circles(0);
  Points again = arc(0.1, 1.4, 20, 1.004);
  // The third circle lies in the xy plane.
  fixtures::add_polyline(sketch, again);
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_EQ(cleaned.n_strokes, 4);
  EXPECT_EQ(cleaned.n_overdrawn, 1);
  const NetworkTopology topology = network_topology(cleaned.network);
  EXPECT_EQ(topology.nodes.size(), 6u);
  EXPECT_EQ(topology.segments.size(), 12u);
}

// A hand closes a circle by drawing on over its beginning: here by 20 degrees, 0.3 % of the diameter outside.
TEST(CleanSketch, ClosesACircleDrawnOverItsBeginning) {
  CurveNetwork sketch = missing_circles(0);
  sketch.curves.pop_back();
  Points circle = arc(0.3, 0.3 + 2 * kPi + radians(20), 100);
  for (Eigen::Index i = 0; i < circle.rows(); ++i)
    circle.row(i) *= 1 + 0.01 * static_cast<double>(i) / static_cast<double>(circle.rows());
  fixtures::add_polyline(sketch, circle);
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_EQ(cleaned.n_overdrawn, 1);
  const NetworkTopology topology = network_topology(cleaned.network);
  EXPECT_EQ(topology.nodes.size(), 6u);
  EXPECT_EQ(topology.segments.size(), 12u);
}

// An arc across an octant that stops short of both circles by 1.2 % of the diameter: both ends are named as
// near misses, reach them, and split the octant. Two nodes and three segments more: 8 nodes, 15 segments.
TEST(CleanSketch, ExtendsEndsThatStopShort) {
  CurveNetwork sketch = missing_circles(0);
  const double diameter = bounding_box_diagonal(sketch.positions);
  const double gap = 0.012 * diameter;
  // Between the plane y = 0 and the plane x = 0, at 45 degrees latitude.
  const double r = std::sqrt(0.5), short_of = gap / r;
  fixtures::add_polyline(sketch, arc(short_of, kPi / 2 - short_of, 20, r, r));
  const CleanedStrokes cleaned = clean_strokes(sketch);
  ASSERT_EQ(count(cleaned, NetworkDefect::NearMiss), 2);
  EXPECT_EQ(cleaned.n_extended_ends, 2);
  for (const NetworkFinding& finding : cleaned.findings)
    if (finding.defect == NetworkDefect::NearMiss) {
      EXPECT_NEAR(finding.distance, gap, 0.1 * gap);
    }
  const NetworkTopology topology = network_topology(cleaned.network);
  EXPECT_EQ(topology.nodes.size(), 8u);
  EXPECT_EQ(topology.segments.size(), 15u);
  // Out of reach the arc is left out, in words with its place.
  StrokeCleaningOptions near;
  near.reach = 0.006;
  const CleanedStrokes without = clean_strokes(sketch, near);
  EXPECT_EQ(network_topology(without.network).segments.size(), 12u);
  EXPECT_EQ(without.n_left_out, 1);
  ASSERT_EQ(without.warnings.size(), 1u);
  EXPECT_NE(without.warnings[0].find("ends in nothing"), std::string::npos) << without.warnings[0];
}

// Two ends that stop short of each other meet once, not twice.
TEST(CleanSketch, LeadsTwoEndsToEachOther) {
  CurveNetwork sketch = missing_circles(0);
  sketch.curves.pop_back();
  fixtures::add_polyline(sketch, arc(0.4, 0.4 + 2 * kPi - 0.03, 80));
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_EQ(cleaned.n_extended_ends, 1);
  EXPECT_EQ(network_topology(cleaned.network).segments.size(), 12u);
  EXPECT_EQ(network_topology(cleaned.network).nodes.size(), 6u);
}

// One line between two parts is no border of two patches.
TEST(CleanSketch, LeavesOutBridges) {
  CurveNetwork sketch = fixtures::three_great_circles(8);
  CurveNetwork other = sketch;
  const auto n = static_cast<int>(sketch.positions.rows());
  other.positions.rowwise() += Eigen::RowVector3d(4, 0, 0);
  sketch.positions.conservativeResize(2 * n, 3);
  sketch.positions.bottomRows(n) = other.positions;
  for (NetworkCurve curve : other.curves) {
    for (int& v : curve.vertices) v += n;
    sketch.curves.push_back(std::move(curve));
  }
  fixtures::add_polyline(sketch, fixtures::line({1, 0, 0}, {3, 0, 0}, 10));
  sketch.normals.resize(0, 3);
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_EQ(cleaned.n_left_out, 1);
  ASSERT_EQ(cleaned.warnings.size(), 1u);
  EXPECT_NE(cleaned.warnings[0].find("only way between two parts"), std::string::npos);
  const NetworkTopology topology = network_topology(cleaned.network);
  EXPECT_EQ(topology.n_components, 2);
  EXPECT_EQ(topology.segments.size(), 24u);
}

// A ring of 40 tolerances and a loop of less than three: the small one is no patch.
TEST(CleanSketch, CollapsesNodesThatLieTogether) {
  CurveNetwork sketch = missing_circles(0);
  fixtures::add_polyline(sketch, arc(0, 2 * kPi, 30, 0.005, 1));
  sketch.curves.back().vertices.back() = sketch.curves.back().vertices.front();
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_EQ(network_topology(cleaned.network).segments.size(), 12u);
}

// A part that welding draws together to nothing does not vanish without a word. The small circles are 0.2 %
// of the large ones; what runs along a longer stroke is no loss.
TEST(CleanSketch, TellsStrokesOfWhichNothingIsLeft) {
  CurveNetwork sketch = missing_circles(0);
  const auto n = sketch.positions.rows();
  const auto n_large = sketch.curves.size();
  sketch.positions.conservativeResize(4 * n, 3);
  sketch.positions.middleRows(n, n) =
      (0.002 * sketch.positions.topRows(n)).rowwise() + Eigen::RowVector3d(1, 2, 0);
  sketch.positions.bottomRows(2 * n) << sketch.positions.topRows(n), sketch.positions.topRows(n);
  for (size_t c = 0; c < n_large; ++c) {
    NetworkCurve small = sketch.curves[c];
    for (int& v : small.vertices) v += static_cast<int>(n);
    small.name = "small";
    sketch.curves.push_back(std::move(small));
  }
  NetworkCurve again = sketch.curves[0];
  for (int& v : again.vertices) v += static_cast<int>(2 * n);
  sketch.curves.push_back(again);
  StrokeCleaningOptions options;
  options.weld_tolerance = 0.01;
  const CleanedStrokes cleaned = clean_strokes(sketch, options);
  EXPECT_EQ(cleaned.n_left_out, 3);
  ASSERT_EQ(cleaned.warnings.size(), 3u);
  for (const std::string& warning : cleaned.warnings)
    EXPECT_NE(warning.find("small"), std::string::npos) << warning;
  options.weld_tolerance = 1e-5;
  options.shortest_side = 0;
  EXPECT_EQ(clean_strokes(sketch, options).n_left_out, 0);
}

TEST(CleanSketch, GivesNothingWhereNothingCloses) {
  CurveNetwork sketch;
  fixtures::add_polyline(sketch, fixtures::line({0, 0, 0}, {1, 0, 0}, 5));
  const CleanedStrokes cleaned = clean_strokes(sketch);
  EXPECT_TRUE(cleaned.network.curves.empty());
  EXPECT_EQ(count(cleaned, NetworkDefect::DanglingEnd), 2);
}

// Scaled by powers of ten and moved, a sketch gives the same network.
TEST(CleanSketch, DoesNotDependOnScale) {
  const CurveNetwork sketch = missing_circles(0.003);
  const CleanedStrokes expected = clean_strokes(sketch);
  for (const double scale : {1e-3, 1e3}) {
    CurveNetwork scaled = sketch;
    scaled.positions = (scale * scaled.positions).rowwise() + Eigen::RowVector3d(1, 2, 3) * scale;
    const CleanedStrokes cleaned = clean_strokes(scaled);
    ASSERT_EQ(cleaned.network.curves.size(), expected.network.curves.size());
    for (size_t c = 0; c < cleaned.network.curves.size(); ++c)
      EXPECT_EQ(cleaned.network.curves[c].vertices, expected.network.curves[c].vertices);
  }
}

TEST(CleanSketch, RefusesOptionsOutOfRange) {
  const CurveNetwork sketch = missing_circles(0.002);
  StrokeCleaningOptions options;
  options.weld_tolerance = 0;
  EXPECT_THROW(clean_strokes(sketch, options), InvalidInput);
  options = {};
  options.reach = -1;
  EXPECT_THROW(clean_strokes(sketch, options), InvalidInput);
  CurveNetwork point;
  point.positions = Points::Zero(2, 3);
  point.curves = {{"", false, {0, 1}}};
  EXPECT_THROW(clean_strokes(point), InvalidInput);
}

}  // namespace
}  // namespace batten
