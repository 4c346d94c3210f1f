#include "batten/mesh/handles.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

/// Four vertices on the x axis, at 0, 1, 2 and 3: the first stays, the last turns, the others have targets.
struct Row {
  Points positions = Points::Zero(4, 3);
  Handles handles;
  Row() {
    positions.col(0) << 0, 1, 2, 3;
    handles.fixed = {0};
    HandleMotion turn, pull;
    turn.vertices = {3};
    turn.angle = -radians(90.0);
    turn.about << 2, 0, 0;
    turn.translation << 0, 0, 5;
    pull.vertices = {2, 1};
    pull.targets.resize(2, 3);
    pull.targets << 7, 8, 9, 4, 5, 6;
    handles.moved = {turn, pull};
  }
};

TEST(Handles, VerticesAreFixedOnesThenMovedOnesInTheirOrder) {
  const Row row;
  EXPECT_EQ(row.handles.vertices(), (std::vector<int>{0, 3, 2, 1}));
  EXPECT_NEAR(row.handles.largest_angle(), radians(90.0), 1e-15);  // whatever the sense of the turn
  EXPECT_EQ(Handles{}.largest_angle(), 0);
  EXPECT_TRUE(Handles{}.vertices().empty());
}

// A quarter turn clockwise about z through (2, 0, 0), then up: 3 → (2, −1, 5).
TEST(Handles, TurnsThenTranslates) {
  const Row row;
  Points expected(4, 3);
  expected << 0, 0, 0, 2, -1, 5, 7, 8, 9, 4, 5, 6;
  EXPECT_LT((row.handles.targets(row.positions) - expected).norm(), 1e-14);
}

TEST(Handles, SharesLieOnTheArcAndOnStraightWays) {
  const Row row;
  const Points none = row.handles.targets(row.positions, 0), half = row.handles.targets(row.positions, 0.5);
  EXPECT_EQ(none.row(1), row.positions.row(3));
  EXPECT_EQ(none.row(3), row.positions.row(1));
  const double s = std::sqrt(0.5);  // an eighth of a turn
  EXPECT_LT((half.row(1) - Eigen::RowVector3d(2 + s, -s, 2.5)).norm(), 1e-14);
  EXPECT_EQ(half.row(2), Eigen::RowVector3d(4.5, 4, 4.5));
}

TEST(Handles, ProblemsNameHandleAndVertex) {
  const auto problem_after = [](const auto& change) {
    Row row;
    change(row.handles);
    return row.handles.problem(4).value_or("");
  };
  EXPECT_EQ(problem_after([](Handles&) {}), "");
  EXPECT_NE(problem_after([](Handles& h) { h.fixed[0] = 4; }).find("vertex 4"), std::string::npos);
  EXPECT_NE(problem_after([](Handles& h) { h.fixed[0] = -1; }).find("vertex -1"), std::string::npos);
  EXPECT_NE(problem_after([](Handles& h) { h.fixed.push_back(3); }).find("vertex 3 twice"),
            std::string::npos);
  EXPECT_NE(problem_after([](Handles& h) { h.moved[1].vertices.pop_back(); }).find("2 targets for 1"),
            std::string::npos);
  EXPECT_NE(problem_after([](Handles& h) { h.moved[0].axis.setZero(); }).find("handle 0"), std::string::npos);
  EXPECT_NE(problem_after([](Handles& h) { h.moved[1].targets(0, 0) = std::nan(""); }).find("handle 1"),
            std::string::npos);
  EXPECT_NE(problem_after([](Handles& h) {
              h.moved[0].angle = std::numeric_limits<double>::infinity();
            }).find("finite"),
            std::string::npos);
}

}  // namespace
}  // namespace batten
