#include "batten/strokes/estimated_cycles.hpp"

#include "network/sample_networks.hpp"
#include "network/sphere_network.hpp"
#include "network/torus_grid.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

using Patches = std::multiset<std::multiset<std::set<int>>>;

/// Cycles as sets of the vertices of their loops: the same for a surface seen from inside, and `number` may
/// rename the vertices.
Patches patches(const std::vector<NetworkCycle>& cycles, const std::vector<int>& number = {}) {
  Patches result;
  for (const NetworkCycle& cycle : cycles) {
    std::multiset<std::set<int>> loops;
    for (const NetworkCycle::Loop& loop : cycle.loops) {
      std::set<int> vertices;
      for (const int v : loop.vertices) vertices.insert(number.empty() ? v : number[static_cast<size_t>(v)]);
      loops.insert(vertices);
    }
    result.insert(loops);
  }
  return result;
}

/// Straight edges between points, `n` samples each.
CurveNetwork wireframe(const std::vector<Eigen::RowVector3d>& corners,
                       const std::vector<std::array<int, 2>>& edges, int n = 6) {
  samples::NetworkBuilder builder;
  for (const auto& [a, b] : edges)
    builder.curve(
        n, false,
        [&, a = a, b = b](double t) {
          return Vector3d((1 - t) * corners[static_cast<size_t>(a)] + t * corners[static_cast<size_t>(b)]);
        },
        [](const Vector3d&) { return Vector3d(0, 0, 1); });
  return samples::without_normals(builder.build());
}

CurveNetwork cube() {
  std::vector<Eigen::RowVector3d> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return wireframe(
      corners,
      {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}});
}

/// A tube of radius 1 and height 2: two rims, four lines between them.
CurveNetwork drum() {
  samples::NetworkBuilder builder;
  const auto any = [](const Vector3d&) { return Vector3d(0, 0, 1); };
  for (const double z : {-1.0, 1.0})
    builder.curve(
        32, false, [&](double t) { return Vector3d(std::cos(2 * kPi * t), std::sin(2 * kPi * t), z); }, any);
  for (int i = 0; i < 4; ++i)
    builder.curve(
        8, false, [&](double t) { return Vector3d(std::cos(kPi * i / 2), std::sin(kPi * i / 2), 2 * t - 1); },
        any);
  return samples::without_normals(builder.build());
}

class SharedNetworks : public testing::TestWithParam<const char*> {};

// The networks lie on known surfaces and bring their normals; the answer is what find_cycles() makes of
// those. The estimate knows the curves alone: 2 to 4 degrees off on average, 20 at worst (on the inner side
// of the torus), against bounds that leave a little room.
TEST_P(SharedNetworks, HaveTheSameCyclesAndSimilarNormalsWithoutTheirNormals) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/networks/" + GetParam() + ".net";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const CurveNetwork network = read_network(path);
  const EstimatedCycles estimate = estimate_cycles(samples::without_normals(network));
  EXPECT_EQ(patches(estimate.cycles), patches(find_cycles(network).cycles));
  EXPECT_TRUE(estimate.warnings.empty());
  double agreement = 0;
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) agreement += estimate.normals.row(v).dot(network.normals.row(v));
  const double side = agreement < 0 ? -1 : 1;  // an open surface has no outside
  double sum = 0, worst = 0, count = 0;
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) {
      EXPECT_NEAR(estimate.normals.row(v).norm(), 1, 1e-12);
      const double cosine = side * estimate.normals.row(v).dot(network.normals.row(v));
      const double angle = degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
      sum += angle;
      ++count;
      worst = std::max(worst, angle);
    }
  EXPECT_LT(sum / count, 5);
  EXPECT_LT(worst, 25);
}
INSTANTIATE_TEST_SUITE_P(EstimatedCycles, SharedNetworks,
                         testing::Values("bumpycube", "dish", "ellipsoid5", "saddle", "sphere3", "sphere6",
                                         "torus", "waves"),
                         [](const auto& network) { return std::string(network.param); });

// By symmetry the normal at a corner of the cube is its diagonal, in the middle of an edge the bisector of
// the two faces. Six faces, no handle.
TEST(EstimatedCycles, OfACubeAreItsFaces) {
  const EstimatedCycles estimate = estimate_cycles(cube());
  ASSERT_EQ(estimate.cycles.size(), 6u);
  EXPECT_EQ(estimate.n_handles, 0);
  EXPECT_TRUE(estimate.open_curves.empty());
  const CurveNetwork network = cube();
  for (const NetworkCycle& cycle : estimate.cycles) {
    ASSERT_EQ(cycle.loops.size(), 1u);
    EXPECT_EQ(cycle.loops[0].segments.size(), 4u);
    // A face lies in a plane: one coordinate is the same all along.
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      double low = 2, high = -2;
      for (const int v : cycle.loops[0].vertices) {
        low = std::min(low, network.positions(v, axis));
        high = std::max(high, network.positions(v, axis));
      }
      least = std::min(least, high - low);
    }
    EXPECT_NEAR(least, 0, 1e-12);
  }
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v) {
    const Eigen::RowVector3d p = network.positions.row(v);
    if (p.norm() > 1.7) {  // a corner
      EXPECT_NEAR(estimate.normals.row(v).dot(p.normalized()), 1, 1e-9);
    } else if (p.cwiseAbs().minCoeff() < 1e-12) {  // the middle of an edge
      EXPECT_NEAR(estimate.normals.row(v).dot(p.normalized()), 1, 1e-3);
    }
  }
}

// Loops run counter-clockwise seen from outside: the vector areas of a closed surface give its volume, 8
// here.
TEST(EstimatedCycles, RunCounterClockwiseSeenFromOutside) {
  const CurveNetwork network = cube();
  double volume = 0;
  for (const NetworkCycle& cycle : estimate_cycles(network).cycles) {
    const std::vector<int>& loop = cycle.loops[0].vertices;
    for (size_t i = 1; i + 1 < loop.size(); ++i)
      volume += Vector3d(network.positions.row(loop[0]))
                    .dot(Vector3d(network.positions.row(loop[i]))
                             .cross(Vector3d(network.positions.row(loop[i + 1])))) /
                6;
  }
  EXPECT_NEAR(volume, 8, 1e-9);
}

// m n patches and one handle, whatever the waves; Euler: m n - 2 m n + m n = 0.
TEST(EstimatedCycles, OfATorusKeepItsHole) {
  for (const int n : {3, 4, 7}) {
    const EstimatedCycles estimate = estimate_cycles(fixtures::torus_grid(n, n + 2, 10, 0.1));
    EXPECT_EQ(estimate.cycles.size(), static_cast<size_t>(n * (n + 2)));
    EXPECT_EQ(estimate.n_handles, 1);
    EXPECT_EQ(estimate.n_one_sided, 0);
    EXPECT_TRUE(estimate.warnings.empty());
  }
}

// The flat ends of a drum meet its wall at a right angle: four patches around, two ends.
TEST(EstimatedCycles, OfADrumAreItsWallAndItsEnds) {
  const EstimatedCycles estimate = estimate_cycles(drum());
  EXPECT_EQ(estimate.cycles.size(), 6u);
  EXPECT_EQ(estimate.n_handles, 0);
  EXPECT_TRUE(estimate.open_curves.empty());
}

// The back of a sheet would lie on its front: it is open, tagged or not. Four patches by construction.
TEST(EstimatedCycles, OfAnOpenSheetLeaveItsBackOut) {
  const auto wave = [](double x, double y) { return 0.2 * std::sin(2 * x) * y; };
  for (const bool tagged : {false, true}) {
    const CurveNetwork network = samples::without_normals(samples::square_graph(8, tagged, wave));
    const EstimatedCycles estimate = estimate_cycles(network);
    EXPECT_EQ(estimate.cycles.size(), 4u);
    // The four curves of the border come first.
    EXPECT_EQ(estimate.open_curves, tagged ? std::vector<int>() : (std::vector<int>{0, 1, 2, 3}));
  }
}

/// One network beside another.
CurveNetwork both(const CurveNetwork& one, const CurveNetwork& other) {
  CurveNetwork network = one;
  const auto n = static_cast<int>(one.positions.rows());
  network.positions.resize(n + other.positions.rows(), 3);
  network.positions << one.positions, other.positions;
  for (NetworkCurve curve : other.curves) {
    for (int& v : curve.vertices) v += n;
    network.curves.push_back(std::move(curve));
  }
  return network;
}

// A cube above a sheet: the outside of the sheet bounds no patch, nor does it take one from the cube.
TEST(EstimatedCycles, OfASheetLeaveAClosedPartAlone) {
  const CurveNetwork sheet = samples::without_normals(
      samples::square_graph(8, false, [](double x, double y) { return 0.1 * x * y; }));
  for (const double height : {1.0, 2.0, 4.0}) {
    CurveNetwork box = cube();
    box.positions = (0.3 * box.positions).rowwise() + Eigen::RowVector3d(0.6 * height, 0, height);
    const EstimatedCycles estimate = estimate_cycles(both(sheet, box));
    EXPECT_EQ(estimate.cycles.size(), 4u + 6u) << height;
    EXPECT_EQ(estimate.open_curves, (std::vector<int>{0, 1, 2, 3})) << height;
  }
}

// A circle drawn on a face of a cube divides it into a disc and the rest; both are patches, and the cube
// stays closed.
TEST(EstimatedCycles, OfALoopOnAFaceAreBothOfItsSides) {
  samples::NetworkBuilder builder;
  builder.curve(
      24, false,
      [](double t) { return Vector3d(0.4 * std::cos(2 * kPi * t), 0.4 * std::sin(2 * kPi * t), 1); },
      [](const Vector3d&) { return Vector3d(0, 0, 1); });
  const EstimatedCycles estimate = estimate_cycles(both(cube(), samples::without_normals(builder.build())));
  EXPECT_EQ(estimate.cycles.size(), 7u);
  EXPECT_EQ(std::count_if(estimate.cycles.begin(), estimate.cycles.end(),
                          [](const NetworkCycle& cycle) { return cycle.loops.size() == 2; }),
            1);
  EXPECT_TRUE(estimate.open_curves.empty());
}

// Moved, scaled, with vertices and curves in another order and turned round, a network has the same patches,
// and its normals turn along.
TEST(EstimatedCycles, DoNotDependOnPlaceScaleOrOrder) {
  Random random(3);
  const std::vector<CurveNetwork> networks{cube(), drum(), fixtures::torus_grid(4, 6, 8, 0.15),
                                           samples::without_normals(samples::octahedral_sphere(8))};
  for (const CurveNetwork& network : networks) {
    const EstimatedCycles expected = estimate_cycles(network);
    for (const double scale : {1e-3, 1.0, 1e3}) {
      const Eigen::Matrix3d rotation =
          Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
      const auto n = static_cast<int>(network.positions.rows());
      std::vector<int> number(static_cast<size_t>(n)), back(number.size());
      std::iota(number.begin(), number.end(), 0);
      for (int i = n - 1; i > 0; --i)
        std::swap(number[static_cast<size_t>(i)], number[static_cast<size_t>(random.uniform() * (i + 1))]);
      CurveNetwork moved = network;
      for (int v = 0; v < n; ++v) {
        back[static_cast<size_t>(number[static_cast<size_t>(v)])] = v;
        moved.positions.row(number[static_cast<size_t>(v)]) =
            scale * (network.positions.row(v) * rotation.transpose() + Eigen::RowVector3d(3, -1, 2));
      }
      for (NetworkCurve& curve : moved.curves)
        for (int& v : curve.vertices) v = number[static_cast<size_t>(v)];
      std::reverse(moved.curves.begin(), moved.curves.end());
      for (size_t c = 0; c < moved.curves.size(); c += 2)
        std::reverse(moved.curves[c].vertices.begin(), moved.curves[c].vertices.end());
      const EstimatedCycles estimate = estimate_cycles(moved);
      EXPECT_EQ(patches(estimate.cycles, back), patches(expected.cycles));
      for (int v = 0; v < n; ++v)
        EXPECT_NEAR(
            (estimate.normals.row(number[static_cast<size_t>(v)]) * rotation).dot(expected.normals.row(v)), 1,
            1e-6)
            << "vertex " << v << " of " << n << ", scale " << scale;
    }
  }
}

// A curve given in pieces that follow each other is the same curve: the nodes between them do not branch.
TEST(EstimatedCycles, DoNotDependOnWhereCurvesAreCut) {
  const CurveNetwork whole = drum();
  CurveNetwork cut = whole;
  cut.curves.clear();
  for (const NetworkCurve& curve : whole.curves) {
    const auto middle = curve.vertices.begin() + 3;
    cut.curves.push_back({"", false, {curve.vertices.begin(), middle + 1}});
    cut.curves.push_back({"", false, {middle, curve.vertices.end()}});
  }
  EXPECT_EQ(patches(estimate_cycles(cut).cycles), patches(estimate_cycles(whole).cycles));
}

// Positions off by 2 % of the radius, ten times what sketches are, do not change the patches.
TEST(EstimatedCycles, StandUnevenCurves) {
  CurveNetwork network = fixtures::torus_grid(5, 8, 10, 0.1);
  const Patches expected = patches(estimate_cycles(network).cycles);
  Random random(8);
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v)
    for (int k = 0; k < 3; ++k) network.positions(v, k) += 0.02 * (2 * random.uniform() - 1);
  EXPECT_EQ(patches(estimate_cycles(network).cycles), expected);
}

// Spokes from the centre of an octahedron to its corners: no surface has all of them, so some place must be
// told; which reading is taken is free.
TEST(EstimatedCycles, AreToldWhereCurvesCanBeReadInSeveralWays) {
  std::vector<Eigen::RowVector3d> corners{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0},
                                          {0, 0, 1}, {0, 0, -1}, {0, 0, 0}};
  std::vector<std::array<int, 2>> edges;
  for (int a = 0; a < 6; ++a) {
    edges.push_back({a, 6});
    for (int b = a + 1; b < 6; ++b)
      if (b / 2 != a / 2) edges.push_back({a, b});
  }
  const EstimatedCycles estimate = estimate_cycles(wireframe(corners, edges));
  ASSERT_FALSE(estimate.warnings.empty());
  EXPECT_NE(estimate.warnings[0].find("not certain"), std::string::npos) << estimate.warnings[0];
}

TEST(EstimatedCycles, RefuseWhatIsNoNetwork) {
  EXPECT_THROW(estimate_cycles(CurveNetwork()), InvalidInput);
  CurveNetwork loose = cube();
  fixtures::add_polyline(loose, fixtures::line({5, 0, 0}, {6, 0, 0}, 4));
  try {
    estimate_cycles(loose);
    FAIL() << "a dangling curve was taken";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("without meeting another curve"), std::string::npos);
  }
  CurveNetwork broken = cube();
  broken.positions(3, 1) = std::nan("");
  EXPECT_THROW(estimate_cycles(broken), InvalidInput);
  broken = cube();
  broken.positions.row(broken.curves[0].vertices[2]) = broken.positions.row(broken.curves[0].vertices[1]);
  EXPECT_THROW(estimate_cycles(broken), InvalidInput);
}

// Orders of so many curves took 200 s and 6 GB for 1,000 strokes, and none of them was sure.
TEST(EstimatedCycles, RefuseATangleByItsPlace) {
  CurveNetwork meridians;
  meridians.positions.resize(222, 3);
  meridians.positions.topRows(2) << 0, 0, 1, 0, 0, -1;
  for (int k = 0; k < 220; ++k) {
    const double u = 2 * kPi * k / 220;
    meridians.positions.row(2 + k) << std::cos(u), std::sin(u), 0;
    NetworkCurve curve;
    curve.vertices = {0, 2 + k, 1};
    meridians.curves.push_back(curve);
  }
  try {
    estimate_cycles(meridians);
    FAIL() << "220 curves were put in order";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("220 pieces meet at (0, 0, 1)"), std::string::npos)
        << error.what();
  }
}

TEST(EstimatedCycles, CanBeCancelled) {
  EXPECT_THROW(estimate_cycles(cube(), Progress([](std::string_view, double) { return false; })), Cancelled);
}

}  // namespace
}  // namespace batten
