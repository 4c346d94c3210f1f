#include "batten/pipeline/network_of_strokes.hpp"

#include "network/torus_grid.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {
namespace {

CurveNetwork torus_strokes() {
  return fixtures::unwelded(fixtures::torus_grid(4, 6, 10, 0.1));
}

TEST(NetworkOfStrokes, CountsWhatTheStrokesAmountTo) {
  const CurveNetwork strokes = torus_strokes();
  const NetworkOfStrokes made = network_of_strokes(strokes);
  EXPECT_EQ(made.n_strokes, 10);  // 4 circles one way, 6 the other
  EXPECT_EQ(made.cycles.size(), 24u);
  EXPECT_EQ(made.n_handles, 1);
  EXPECT_EQ(made.n_dangling_ends, 0);
  EXPECT_TRUE(made.network.has_normals());
  EXPECT_DOUBLE_EQ(made.diameter, bounding_box_diagonal(strokes.positions));
  EXPECT_GT(made.weld_tolerance, 0);
}

TEST(NetworkOfStrokes, LengthsMayBeRelativeOrInTheUnitOfTheFile) {
  const CurveNetwork strokes = torus_strokes();
  const double diameter = bounding_box_diagonal(strokes.positions);
  NetworkOfStrokesOptions relative, absolute;
  relative.step = {0.03, Length::Kind::Relative};
  absolute.step = {0.03 * diameter, Length::Kind::Plain};
  const NetworkOfStrokes by_part = network_of_strokes(strokes, relative);
  EXPECT_EQ(by_part.network.positions.rows(), network_of_strokes(strokes, absolute).network.positions.rows());
  EXPECT_LT(by_part.network.positions.rows(), network_of_strokes(strokes).network.positions.rows());
}

TEST(NetworkOfStrokes, BadOptionsAndStrokesWithoutExtentAreNamed) {
  NetworkOfStrokesOptions options;
  options.weld = Length{0, Length::Kind::Plain};
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_NE(options.problem()->find("weld"), std::string::npos);
  EXPECT_THROW(network_of_strokes(torus_strokes(), options), InvalidInput);
  CurveNetwork point = torus_strokes();
  point.positions.setZero();
  EXPECT_THROW(network_of_strokes(point), InvalidInput);
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
