#include "camera/boards.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

TEST(Board, NumbersItsCornersRowByRow) {
  const Board board{.columns = 9, .rows = 6, .square = 0.025};
  EXPECT_EQ(board.n_corners(), 54);
  EXPECT_TRUE(board.corner(0).isZero());
  EXPECT_TRUE(board.corner(8).isApprox(Eigen::Vector3d(0.2, 0, 0)));
  EXPECT_TRUE(board.corner(9).isApprox(Eigen::Vector3d(0, 0.025, 0)));
}

// After half a turn corner (c, r) comes to (n − 1 − c, m − 1 − r), on a square of the same colour where n + m
// is even.
TEST(Board, IsRefusedWhereHalfATurnDoesNotShow) {
  EXPECT_FALSE((Board{.columns = 9, .rows = 6}).problem());
  EXPECT_FALSE((Board{.columns = 6, .rows = 9}).problem());
  for (const Board& board : {Board{.columns = 8, .rows = 6}, Board{.columns = 9, .rows = 7}})
    EXPECT_NE(board.problem().value_or("").find("half a turn"), std::string::npos);
  EXPECT_TRUE((Board{.columns = 2, .rows = 3}).problem());
  EXPECT_TRUE((Board{.columns = 9, .rows = 6, .square = 0}).problem());
}

TEST(Board, IsReadFromItsCounts) {
  const Board board = parse_board("7x4", 0.01);
  EXPECT_EQ(board.columns, 7);
  EXPECT_EQ(board.rows, 4);
  EXPECT_EQ(board.square, 0.01);
  for (const char* text : {"", "9", "9x", "x6", "9x6x2", "-9x6", "9 by 6"})
    EXPECT_THROW(parse_board(text, 0.01), InvalidInput) << text;
}

TEST(BoardPairs, NameWhatIsWrongWithThem) {
  const BoardPairs good = shown_boards(webcam_rig(), {.pairs = 2});
  EXPECT_FALSE(problem(good));
  BoardPairs bad = good;
  bad.pairs[1].right(3, 0) = 641;
  EXPECT_EQ(problem(bad).value_or(""),
            "corner 3 of pair 2 lies outside of the right image of 640 x 480 pixels");
  bad = good;
  bad.pairs[0].left.conservativeResize(53, 2);
  EXPECT_NE(problem(bad).value_or("").find("pair 1"), std::string::npos);
  bad = good;
  bad.left_width = 0;
  EXPECT_TRUE(problem(bad));
}

TEST(BoardPairs, CountCornersThatBothCamerasSee) {
  BoardPairs pairs = shown_boards(webcam_rig(), {.pairs = 1});
  pairs.pairs[0].left(0, 0) = std::numeric_limits<double>::quiet_NaN();
  pairs.pairs[0].right(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(pairs.pairs[0].n_common(), 52);
  EXPECT_FALSE(pairs.pairs[0].in_left(0));
  EXPECT_TRUE(pairs.pairs[0].in_right(0));
}

}  // namespace
}  // namespace batten::test
