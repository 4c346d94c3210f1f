#include "batten/strokes/stroke_network.hpp"

#include "network/torus_grid.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/io/network_io.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {
namespace {

struct KnownSketch {
  const char* file;
  size_t nodes, segments, cycles;
  int handles;
};
void PrintTo(const KnownSketch& sketch, std::ostream* out) {
  *out << sketch.file;
}

class CleanSketches : public testing::TestWithParam<KnownSketch> {};

// Trebol: 18 nodes and 36 arcs as its table says, so 20 patches on a closed surface without handles. Torus:
// 16 crossings of four and four circles. The others: crossings counted in their pictures; patches from
// Euler's formula for closed surfaces of that genus.
TEST_P(CleanSketches, GiveTheirPatches) {
  const KnownSketch& known = GetParam();
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/curves/" + known.file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const StrokeNetwork made = stroke_network(read_network(path));
  const NetworkTopology topology = network_topology(made.network);
  EXPECT_EQ(topology.nodes.size(), known.nodes);
  EXPECT_EQ(topology.segments.size(), known.segments);
  EXPECT_EQ(topology.n_components, 1);
  EXPECT_EQ(made.estimate.cycles.size(), known.cycles);
  EXPECT_EQ(made.estimate.n_handles, known.handles);
  EXPECT_EQ(made.estimate.n_one_sided, 0);
  EXPECT_TRUE(made.estimate.open_curves.empty());
  EXPECT_TRUE(made.estimate.warnings.empty());
  EXPECT_EQ(made.strokes.n_left_out, 0);
  EXPECT_TRUE(made.network.has_normals());
}
INSTANTIATE_TEST_SUITE_P(StrokeNetwork, CleanSketches,
                         testing::Values(KnownSketch{"sketch_trebol_flowrep.obj", 18, 36, 20, 0},
                                         KnownSketch{"sketch_torus.obj", 16, 32, 16, 1},
                                         KnownSketch{"sketch_spherecylinder.obj", 14, 28, 16, 0},
                                         KnownSketch{"sketch_box.obj", 29, 57, 30, 0},
                                         KnownSketch{"sketch_bathtub.obj", 72, 138, 68, 0},
                                         KnownSketch{"sketch_dress.obj", 4, 8, 6, 0}),
                         [](const auto& sketch) {
                           const std::string file = sketch.param.file;
                           return file.substr(7, file.find('.') - 7);
                         });

struct RoughSketch {
  const char* file;
  int strokes, free_ends;
};
void PrintTo(const RoughSketch& sketch, std::ostream* out) {
  *out << sketch.file;
}

class RoughSketches : public testing::TestWithParam<RoughSketch> {};

// Strokes and free ends as the table of the data counts them. Every free end is named once: it lies on
// another stroke, stops short of one, or dangles; and the finding lies at that end.
TEST_P(RoughSketches, HaveEveryFreeEndListed) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/curves/" + GetParam().file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const CurveNetwork sketch = read_network(path);
  const StrokeNetwork made = stroke_network(sketch);
  EXPECT_EQ(made.strokes.n_strokes, GetParam().strokes);
  int named = 0;
  for (const NetworkFinding& finding : made.strokes.findings)
    if (finding.defect == NetworkDefect::DanglingEnd || finding.defect == NetworkDefect::NearMiss ||
        finding.defect == NetworkDefect::TJunction) {
      ++named;
      EXPECT_FALSE(finding.sentence.empty());
      const double distance =
          (sketch.positions.rowwise() - finding.position.transpose()).rowwise().norm().minCoeff();
      EXPECT_EQ(distance, 0);
    }
  EXPECT_EQ(named, GetParam().free_ends);
  EXPECT_GT(made.estimate.cycles.size(), 20u);
}
INSTANTIATE_TEST_SUITE_P(StrokeNetwork, RoughSketches,
                         testing::Values(RoughSketch{"sketch_gamepad.obj", 108, 216},
                                         RoughSketch{"sketch_guitar.obj", 85, 170},
                                         RoughSketch{"sketch_car.obj", 68, 43}),
                         [](const auto& sketch) {
                           const std::string file = sketch.param.file;
                           return file.substr(7, file.find('.') - 7);
                         });

// 114 curves that cross every few samples: what is too short to bound a patch goes, the rest stays. A net of
// four curves at a node has as many patches as nodes, less the border; 1,177 nodes are left here, many of
// six.
TEST(StrokeNetwork, StandsDenseCurves) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/curves/kagome_114_regular.txt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  StrokeNetworkOptions options;
  options.weld_tolerance = 0.005;
  const StrokeNetwork made = stroke_network(read_network(path), options);
  EXPECT_GT(made.estimate.cycles.size(), network_topology(made.network).nodes.size());
  for (const NetworkCycle& cycle : made.estimate.cycles)
    for (const NetworkCycle::Loop& loop : cycle.loops) EXPECT_GE(loop.vertices.size(), 3u);
}

// Circles of a torus that miss each other by up to 0.9 % of the diameter: the least tolerance that is tried
// joins some of them only; a larger one gives the torus, 5 × 8 patches and its hole.
TEST(StrokeNetwork, FindsTheToleranceThatTheSketchNeeds) {
  const CurveNetwork exact = fixtures::torus_grid(5, 8, 10, 0);
  CurveNetwork sketch = fixtures::unwelded(exact);
  const double diameter = bounding_box_diagonal(sketch.positions);
  Random random(5);
  for (size_t c = 0; c < sketch.curves.size(); ++c) {
    const Eigen::RowVector3d shift =
        0.0045 * diameter * random.normal3().normalized().transpose() * (c % 2 == 0 ? 1 : -1);
    for (size_t k = 0; k + 1 < sketch.curves[c].vertices.size(); ++k)
      sketch.positions.row(sketch.curves[c].vertices[k]) += shift;
  }
  const StrokeNetwork made = stroke_network(sketch);
  EXPECT_GT(made.weld_tolerance, 0.005);
  EXPECT_EQ(made.estimate.cycles.size(), 40u);
  EXPECT_EQ(made.estimate.n_handles, 1);
  StrokeNetworkOptions tight;
  tight.weld_tolerance = 0.004;
  EXPECT_NE(stroke_network(sketch, tight).estimate.cycles.size(), 40u);
}

// Exact strokes need no tolerance but the least.
TEST(StrokeNetwork, TakesTheLeastToleranceThatWillDo) {
  const StrokeNetwork made = stroke_network(fixtures::unwelded(fixtures::torus_grid(4, 6, 10, 0.1)));
  EXPECT_EQ(made.weld_tolerance, 0.005);
  EXPECT_EQ(made.estimate.cycles.size(), 24u);
}

// Samples lie about `step` apart, or where they lay.
TEST(StrokeNetwork, SamplesTheCurvesEvenly) {
  const CurveNetwork sketch = fixtures::unwelded(fixtures::torus_grid(4, 6, 30, 0));
  StrokeNetworkOptions options;
  options.step = 0.03;
  const StrokeNetwork made = stroke_network(sketch, options);
  const double step = 0.03 * bounding_box_diagonal(sketch.positions);
  for (const NetworkCurve& curve : made.network.curves)
    for (size_t k = 1; k < curve.vertices.size(); ++k) {
      const double length =
          (made.network.positions.row(curve.vertices[k]) - made.network.positions.row(curve.vertices[k - 1]))
              .norm();
      EXPECT_NEAR(length, step, 0.35 * step);
    }
  options.step = 0;
  EXPECT_EQ(stroke_network(sketch, options).network.positions.rows(), made.strokes.network.positions.rows());
}

TEST(StrokeNetwork, SaysWhyThereIsNothingToSurface) {
  CurveNetwork sketch;
  sketch.positions.resize(2, 3);
  sketch.positions << 0, 0, 0, 1, 0, 0;
  sketch.curves = {{"", false, {0, 1}}};
  try {
    stroke_network(sketch);
    FAIL() << "a line was taken for a surface";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("no closed cycle"), std::string::npos) << error.what();
  }
  StrokeNetworkOptions options;
  options.step = 1;
  EXPECT_THROW(stroke_network(fixtures::torus_grid(3, 3, 4, 0), options), InvalidInput);
  options = {};
  options.weld_tolerance = -0.1;
  EXPECT_THROW(stroke_network(fixtures::torus_grid(3, 3, 4, 0), options), InvalidInput);
}

TEST(StrokeNetwork, CountsWhatTheStrokesAmountTo) {
  const CurveNetwork strokes = fixtures::unwelded(fixtures::torus_grid(4, 6, 10, 0.1));
  const StrokeNetwork made = stroke_network(strokes);
  EXPECT_EQ(made.strokes.n_strokes, 10);  // 4 circles one way, 6 the other
  EXPECT_EQ(made.estimate.cycles.size(), 24u);
  EXPECT_EQ(made.estimate.n_handles, 1);
  EXPECT_EQ(count_findings(made.strokes.findings, NetworkDefect::DanglingEnd), 0);
  EXPECT_TRUE(made.network.has_normals());
  EXPECT_DOUBLE_EQ(made.diameter, bounding_box_diagonal(strokes.positions));
  EXPECT_GT(made.weld_tolerance, 0);
  StrokeNetworkOptions coarse;
  coarse.step = 0.03;
  EXPECT_LT(stroke_network(strokes, coarse).network.positions.rows(), made.network.positions.rows());
}

TEST(StrokeNetwork, StrokesWithoutExtentAreNamed) {
  CurveNetwork point = fixtures::unwelded(fixtures::torus_grid(4, 6, 10, 0.1));
  point.positions.setZero();
  try {
    stroke_network(point);
    FAIL() << "a point was taken for strokes";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("no extent"), std::string::npos) << error.what();
  }
}

TEST(StrokeNetwork, OptionsOutOfRangeAreNamed) {
  StrokeNetworkOptions options;
  options.weld_tolerance = -0.1;
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_NE(options.problem()->find("weld"), std::string::npos) << *options.problem();
}

TEST(IsNotable, LeavesOutWhatEveryStrokeSetHas) {
  NetworkFinding finding;
  finding.defect = NetworkDefect::Crossing;
  EXPECT_FALSE(is_notable(finding));
  finding.defect = NetworkDefect::DanglingEnd;
  EXPECT_TRUE(is_notable(finding));
}

}  // namespace
}  // namespace batten
