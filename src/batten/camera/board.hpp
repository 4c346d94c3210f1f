#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace batten {

/// The inner corners of a chessboard, where four squares meet: corner (column, row) lies at
/// (column · square, row · square, 0) of the board and has the index row · columns + column.
struct Board {
  int columns = 9;        ///< inner corners along the rows, at least 3
  int rows = 6;           ///< at least 3
  double square = 0.025;  ///< side of a square, metres, above 0

  int n_corners() const { return columns * rows; }
  /// Place of a corner on the board, metres.
  Eigen::Vector3d corner(int index) const {
    return {index % columns * square, index / columns * square, 0.0};
  }
  /// What is wrong with the board, or nothing. A board of two even or two odd counts looks the same after
  /// half a turn, so that two cameras may count its corners from different ends: it is refused.
  std::optional<std::string> problem() const;
};

/// Reads "9x6" into the counts of a board; the square stays as it is.
/// @throws InvalidInput naming the form.
Board parse_board(const std::string& text, double square);

/// Pixels of the corners of a board, one row per corner; NaN where a corner was not seen.
using BoardCorners = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// One place of the board, seen by both cameras at once.
struct BoardPair {
  int number = 0;      ///< as the file counts it, for sentences
  BoardCorners left;   ///< board.n_corners() × 2
  BoardCorners right;  ///< the same

  /// Whether a corner was seen by one camera, or by both.
  bool in_left(int corner) const { return left.row(corner).allFinite(); }
  bool in_right(int corner) const { return right.row(corner).allFinite(); }
  bool in_both(int corner) const { return in_left(corner) && in_right(corner); }
  int n_common() const;
};

/// What a rig is calibrated from. Pixels count from the outer corner of the first (camera.hpp).
struct BoardPairs {
  Board board;
  int left_width = 0, left_height = 0;    ///< pixels
  int right_width = 0, right_height = 0;  ///< pixels
  std::vector<BoardPair> pairs;
};

/// What is wrong with the pairs, naming pair and camera, or nothing: sizes, matrices of another board,
/// corners outside of their images.
std::optional<std::string> problem(const BoardPairs& pairs);

}  // namespace batten
