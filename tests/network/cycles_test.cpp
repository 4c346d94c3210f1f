#include "batten/network/cycles.hpp"

#include "network/sample_networks.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {
namespace {

using samples::add_circle;
using samples::NetworkBuilder;
using samples::octahedral_sphere;
using samples::square_graph;

/// Twice the signed area of a loop about the mean of its normals: positive where it runs counter-clockwise.
double signed_area(const CurveNetwork& network, const std::vector<int>& loop) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), area = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector3d a = network.positions.row(loop[i]),
                          b = network.positions.row(loop[(i + 1) % loop.size()]);
    normal += network.normals.row(loop[i]).transpose();
    area += a.cross(b);
  }
  return normal.normalized().dot(area);
}

std::string error_of(const CurveNetwork& network) {
  try {
    find_cycles(network);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

// Euler: three great circles have V − E + F = 6 − 12 + 8 = 2, so eight triangles of three segments each.
TEST(FindCycles, FindsTheEightOctantsOfThreeGreatCircles) {
  const CurveNetwork network = octahedral_sphere(5);
  const CycleReport report = find_cycles(network);
  ASSERT_EQ(report.cycles.size(), 8u);
  for (const NetworkCycle& cycle : report.cycles) {
    ASSERT_EQ(cycle.loops.size(), 1u);
    EXPECT_EQ(cycle.loops[0].segments.size(), 3u);
    EXPECT_EQ(cycle.loops[0].vertices.size(), 15u);
    EXPECT_GT(signed_area(network, cycle.loops[0].vertices), 0);
  }
}

// Every side of every segment belongs to one patch: each segment is walked once forwards, once backwards.
TEST(FindCycles, WalksEverySegmentOfAClosedNetworkOnceEachWay) {
  const CurveNetwork network = octahedral_sphere(3);
  std::multiset<int> walked;
  for (const NetworkCycle& cycle : find_cycles(network).cycles)
    for (const int s : cycle.loops[0].segments) walked.insert(s);
  for (std::size_t s = 0; s < network_topology(network).segments.size(); ++s) {
    EXPECT_EQ(walked.count(static_cast<int>(s)), 1u);
    EXPECT_EQ(walked.count(~static_cast<int>(s)), 1u);
  }
}

TEST(FindCycles, LeavesTheOutsideOfATaggedBorderOut) {
  const CurveNetwork network = square_graph(4, true, [](double x, double y) { return 0.2 * x * y; });
  const CycleReport report = find_cycles(network);
  EXPECT_EQ(report.cycles.size(), 4u);
  for (const NetworkCycle& cycle : report.cycles) EXPECT_GT(signed_area(network, cycle.loops[0].vertices), 0);
}

TEST(FindCycles, NamesTheCurvesOfABorderThatIsNotTagged) {
  const CurveNetwork none = square_graph(4, false, [](double, double) { return 0.0; });
  for (const char* part : {"curve 0", "curve 1", "curve 2", "curve 3", "tag"})
    EXPECT_NE(error_of(none).find(part), std::string::npos) << error_of(none);
  EXPECT_EQ(error_of(none).find("curve 4"), std::string::npos) << "inner curves have patches on both sides";
  // One side of four forgotten.
  CurveNetwork partly = square_graph(4, true, [](double, double) { return 0.0; });
  partly.curves[2].boundary = false;
  EXPECT_NE(error_of(partly).find("curve 2"), std::string::npos) << error_of(partly);
  EXPECT_EQ(error_of(partly).find("curve 0"), std::string::npos) << error_of(partly);
}

TEST(FindCycles, FillsALoneBorderLoopFromInside) {
  NetworkBuilder builder;
  builder.curve(
      12, true, [](double t) { return Eigen::Vector3d(std::cos(2 * kPi * t), std::sin(2 * kPi * t), 0); },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 1); });
  const CurveNetwork network = builder.build();
  const CycleReport report = find_cycles(network);
  ASSERT_EQ(report.cycles.size(), 1u);
  EXPECT_GT(signed_area(network, report.cycles[0].loops[0].vertices), 0);
}

// S fig. 4.18: two circles bound one tube whatever their normals say of its shape.
TEST(FindCycles, JoinsTwoCirclesThatFaceEachOtherIntoOneTube) {
  for (const double tilt : {0.0, 0.7, -0.7}) {
    NetworkBuilder builder;
    add_circle(builder, 24, 1, 0, -tilt, true);
    add_circle(builder, 24, 1, 1.5, tilt, true);
    const CycleReport report = find_cycles(builder.build());
    ASSERT_EQ(report.cycles.size(), 1u) << "tilt " << tilt;
    EXPECT_EQ(report.cycles[0].loops.size(), 2u);
  }
}

// A circle half way up the tube that is no border: a patch below it and one above.
TEST(FindCycles, SplitsATubeAtACircleInBetween) {
  NetworkBuilder builder;
  add_circle(builder, 24, 1, 0, 0, true);
  add_circle(builder, 24, 1, 1, 0, false);
  add_circle(builder, 24, 1, 2, 0, true);
  const CycleReport report = find_cycles(builder.build());
  ASSERT_EQ(report.cycles.size(), 2u);
  EXPECT_EQ(report.cycles[0].loops.size(), 2u);
  EXPECT_EQ(report.cycles[1].loops.size(), 2u);
}

// A closed curve inside a disc: the annulus round it and the disc within, loops running opposite ways.
TEST(FindCycles, TakesAnIslandAsAHoleOfItsPatchAndAsAPatch) {
  NetworkBuilder builder;
  const auto up = [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 1); };
  for (const double r : {1.0, 0.4})
    builder.curve(
        40, r == 1.0,
        [r](double t) { return Eigen::Vector3d(r * std::cos(2 * kPi * t), r * std::sin(2 * kPi * t), 0); },
        up);
  const CurveNetwork network = builder.build();
  const CycleReport report = find_cycles(network);
  ASSERT_EQ(report.cycles.size(), 2u);
  std::vector<std::size_t> loops = {report.cycles[0].loops.size(), report.cycles[1].loops.size()};
  std::sort(loops.begin(), loops.end());
  EXPECT_EQ(loops, (std::vector<std::size_t>{1, 2}));
}

TEST(FindCycles, KeepsTwoSpheresApart) {
  CurveNetwork network = octahedral_sphere(4);
  const CurveNetwork other = octahedral_sphere(4, {2.3, 0.4, 0.2});
  const int n = static_cast<int>(network.positions.rows());
  Points positions(2 * n, 3), normals(2 * n, 3);
  positions << network.positions, other.positions;
  normals << network.normals, other.normals;
  network.positions = positions;
  network.normals = normals;
  for (NetworkCurve curve : other.curves) {
    for (int& v : curve.vertices) v += n;
    network.curves.push_back(curve);
  }
  const CycleReport report = find_cycles(network);
  EXPECT_EQ(report.cycles.size(), 16u);
  for (const NetworkCycle& cycle : report.cycles) EXPECT_EQ(cycle.loops.size(), 1u);
}

// Curves that leave a node in the same direction and part only later have no order at the node itself.
TEST(FindCycles, OrdersCurvesThatTouchByWhereTheyPart) {
  NetworkBuilder builder;
  const auto up = [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 1); };
  // Three parabolas from (0,0) to (1, ·): y = 0.3x², 0 and −0.3x², then a border through their ends.
  for (const double a : {0.3, 0.0, -0.3})
    builder.curve(
        20, a != 0, [a](double t) { return Eigen::Vector3d(t, a * t * t, 0); }, up);
  builder.curve(
      10, true, [](double t) { return Eigen::Vector3d(1, -0.3 + 0.3 * t, 0); }, up);
  builder.curve(
      10, true, [](double t) { return Eigen::Vector3d(1, 0.3 * t, 0); }, up);
  const CurveNetwork network = builder.build();
  const CycleReport report = find_cycles(network);
  ASSERT_EQ(report.cycles.size(), 2u);
  for (const NetworkCycle& cycle : report.cycles) EXPECT_GT(signed_area(network, cycle.loops[0].vertices), 0);
}

/// Where curves are straight or follow a formula, in the plane z = 0 with normals up.
void add_flat(NetworkBuilder& builder, int n, bool boundary,
              const std::function<Eigen::Vector3d(double)>& p) {
  builder.curve(n, boundary, p, [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 1); });
}

void expect_patches(const CurveNetwork& network, std::size_t n) {
  const CycleReport report = find_cycles(network);
  ASSERT_EQ(report.cycles.size(), n);
  for (const NetworkCycle& cycle : report.cycles) {
    ASSERT_EQ(cycle.loops.size(), 1u);
    EXPECT_GT(signed_area(network, cycle.loops[0].vertices), 0);
  }
}

// The parabola through the first samples of y = x³ begins downwards: of ±x³ it takes the lower for the upper.
// With another curve at the node a list of them could begin between those that touch.
TEST(FindCycles, OrdersCurvesThatTouchWhateverTheirFirstSamplesSay) {
  for (const bool other : {false, true}) {
    NetworkBuilder builder;
    for (const double a : {0.3, 0.0, -0.3})
      add_flat(builder, 20, !other && a != 0, [a](double t) { return Eigen::Vector3d(t, a * t * t * t, 0); });
    add_flat(builder, 10, true, [](double t) { return Eigen::Vector3d(1, -0.3 + 0.3 * t, 0); });
    add_flat(builder, 10, true, [](double t) { return Eigen::Vector3d(1, 0.3 * t, 0); });
    if (other) {
      add_flat(builder, 10, false, [](double t) { return Eigen::Vector3d(-t, 0, 0); });
      for (const double side : {1.0, -1.0})
        add_flat(builder, 20, true, [side](double t) {
          return Eigen::Vector3d(1 - 2 * t, side * (0.3 * (1 - t) + 2 * t * (1 - t)), 0);
        });
    }
    expect_patches(builder.build(), other ? 4 : 2);
  }
}

// Curves that touch are ordered where they part, and not where one of them has turned behind the other's end.
TEST(FindCycles, OrdersCurvesThatTouchWhereTheyPartFirst) {
  NetworkBuilder builder;
  add_flat(builder, 20, false, [](double t) { return Eigen::Vector3d(t, 0, 0); });
  add_flat(builder, 20, false, [](double t) {  // 11 degrees to the left of the first, then 14 to its right
    return Eigen::Vector3d(2 * t, 2.5 * t * t * (0.8 - t), 0);
  });
  add_flat(builder, 10, false, [](double t) { return Eigen::Vector3d(1, -t, 0); });
  add_flat(builder, 10, true, [](double t) { return Eigen::Vector3d(t, -2 * t + t * t, 0); });
  add_flat(builder, 10, true, [](double t) { return Eigen::Vector3d(1 + t, -1 + 0.5 * t, 0); });
  add_flat(builder, 20, true,
           [](double t) { return Eigen::Vector3d(2 - 2 * t, -0.5 * (1 - t) + 4 * t * (1 - t), 0); });
  expect_patches(builder.build(), 3);
}

// Two discs side by side see each other's outside across the gap, which is no surface.
TEST(FindCycles, FillsTwoDiscsSideBySide) {
  NetworkBuilder builder;
  for (const double x : {0.0, 3.0})
    add_flat(builder, 24, true,
             [x](double t) { return Eigen::Vector3d(x + std::cos(2 * kPi * t), std::sin(2 * kPi * t), 0); });
  expect_patches(builder.build(), 2);
}

// The end of a tube looks at the rim of a disc above it, whose surface goes another way: no tube between
// them.
TEST(FindCycles, JoinsNoLoopsOfWhichOneLooksAway) {
  NetworkBuilder builder;
  add_circle(builder, 24, 1, 0, 0, true);
  add_circle(builder, 24, 0.9, 1.5, 0.5 * kPi, true);
  const CycleReport report = find_cycles(builder.build());
  ASSERT_EQ(report.cycles.size(), 2u);
  for (const NetworkCycle& cycle : report.cycles) EXPECT_EQ(cycle.loops.size(), 1u);
}

// A waist between circles whose normals lean towards each other by the angle a has the total curvature
// 4π sin a, two caps in its place 4π − 4π sin a. The waist has to save π: sin a < 3/8.
TEST(FindCycles, JoinsTwoLoopsWhereThatClearlySavesCurvature) {
  for (const double sine : {0.33, 0.42}) {
    NetworkBuilder builder;
    add_circle(builder, 48, 1, 0, std::asin(sine), false);
    add_circle(builder, 48, 1, 1.5, -std::asin(sine), false);
    std::size_t joined = 0;
    for (const NetworkCycle& cycle : find_cycles(builder.build()).cycles) joined += cycle.loops.size() == 2;
    EXPECT_EQ(joined, sine < 0.375 ? 1u : 0u) << sine;
  }
}

// The rim of a dome has its patches above it, however few curves divide the dome. What it faces below, over a
// waist that is narrow or not, is a disc of its own.
TEST(FindCycles, TheBorderOfADomeBoundsNothingElse) {
  for (const double lean : {0.0, 0.42})
    for (const int n_ribs : {1, 2}) {
      NetworkBuilder builder;
      add_circle(builder, 48, 1, 0, std::asin(lean), true);
      const double out = std::sqrt(1 - lean * lean);
      for (const double begin : {0.0, kPi})
        builder.curve(
            24, true,
            [=](double t) {
              return Eigen::Vector3d(std::cos(begin + kPi * t), std::sin(begin + kPi * t), 1.5);
            },
            [=](const Eigen::Vector3d& x) { return Eigen::Vector3d(out * x.x(), out * x.y(), -lean); });
      for (int rib = 0; rib < n_ribs; ++rib)
        builder.curve(
            24, false,
            [=](double t) {
              Eigen::Vector3d p(0, 0, 1.5 + 0.7 * std::sin(kPi * t));
              p[rib] = std::cos(kPi * t);
              return p;
            },
            [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x.x(), x.y(), 1); });
      const CycleReport report = find_cycles(builder.build());
      EXPECT_EQ(report.cycles.size(), 2u * static_cast<std::size_t>(n_ribs) + 1) << lean << " " << n_ribs;
      for (const NetworkCycle& cycle : report.cycles) EXPECT_EQ(cycle.loops.size(), 1u);
    }
}

// A sheet of two patches, and a loop on one of them: the outside of the sheet bounds nothing, that of the
// loop the patch that it lies on, though both are told as outside.
TEST(CollectCycles, ALoneLoopDividesThePatchItLiesOn) {
  NetworkBuilder builder;
  const auto border = [](double side) {  // half of the square, from (0, side) counter-clockwise to (0, −side)
    return [side](double t) {
      const double s = 4 * t;
      return s < 1   ? Eigen::Vector3d(-side * s, side, 0)
             : s < 3 ? Eigen::Vector3d(-side, side * (2 - s), 0)
                     : Eigen::Vector3d(-side * (4 - s), -side, 0);
    };
  };
  add_flat(builder, 16, false, border(1));
  add_flat(builder, 16, false, border(-1));
  add_flat(builder, 8, false, [](double t) { return Eigen::Vector3d(0, 2 * t - 1, 0); });
  add_flat(builder, 16, false, [](double t) {
    return Eigen::Vector3d(0.5 + 0.2 * std::cos(2 * kPi * t), 0.2 * std::sin(2 * kPi * t), 0);
  });
  const CurveNetwork network = builder.build();
  ASSERT_EQ(network_topology(network).segments.size(), 4u);
  detail::NodeOrders orders;
  orders.half_edges = {{3, 0, 5}, {2, 4, 1}, {6, 7}};
  orders.outside = {0, 1, 0, 1, 0, 0, 0, 1};
  const CycleReport report = detail::collect_cycles(network, orders);
  ASSERT_EQ(report.cycles.size(), 3u);
  std::size_t holes = 0;
  for (const NetworkCycle& cycle : report.cycles) holes += cycle.loops.size() - 1;
  EXPECT_EQ(holes, 1u);
}

TEST(FindCycles, RefusesACurveThatEndsInNothing) {
  CurveNetwork network = octahedral_sphere(3);
  const int v = static_cast<int>(network.positions.rows());
  network.positions.conservativeResize(v + 1, 3);
  network.normals.conservativeResize(v + 1, 3);
  network.positions.row(v) << 0.6, 0.6, 0.6;
  network.normals.row(v) << 0.6, 0.6, 0.6;
  network.curves.push_back({"", false, {network.curves[0].vertices[1], v}});
  EXPECT_NE(error_of(network).find("curve 3 ends at vertex"), std::string::npos) << error_of(network);
}

TEST(FindCycles, NamesWhatIsWrongWithTheInput) {
  CurveNetwork network = octahedral_sphere(3);
  network.positions(4, 1) = std::nan("");
  EXPECT_NE(error_of(network).find("vertex 4"), std::string::npos) << error_of(network);
  network = octahedral_sphere(3);
  network.normals.row(5).setZero();
  EXPECT_NE(error_of(network).find("vertex 5"), std::string::npos) << error_of(network);
  network = octahedral_sphere(3);
  network.normals.resize(0, 3);
  EXPECT_NE(error_of(network).find("no normals"), std::string::npos);
  network = octahedral_sphere(3);
  network.positions.row(1) = network.positions.row(2);
  EXPECT_NE(error_of(network).find("same place"), std::string::npos) << error_of(network);
  EXPECT_NE(error_of(CurveNetwork{}).find("no curves"), std::string::npos);
}

// The patches as sets of positions do not depend on how the file lists curves, nor on their direction.
TEST(FindCycles, DoesNotDependOnTheOrderOfTheCurves) {
  const CurveNetwork network = octahedral_sphere(4);
  CurveNetwork other = network;
  std::reverse(other.curves.begin(), other.curves.end());
  std::reverse(other.curves[1].vertices.begin(), other.curves[1].vertices.end());
  const CycleReport a = find_cycles(network), b = find_cycles(other);
  ASSERT_EQ(a.cycles.size(), b.cycles.size());
  for (std::size_t c = 0; c < a.cycles.size(); ++c)
    EXPECT_EQ(a.cycles[c].loops[0].vertices, b.cycles[c].loops[0].vertices);
}

}  // namespace
}  // namespace batten
