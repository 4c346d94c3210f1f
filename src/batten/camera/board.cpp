#include "batten/camera/board.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

std::optional<std::string> Board::problem() const {
  constexpr int kMost = 100;  // more corners along a side are a slip of the hand
  if (columns < 3 || columns > kMost || rows < 3 || rows > kMost)
    return concat("a board has 3 to ", kMost, " inner corners along each side, got ", columns, "x", rows);
  if (!(square > 0 && square < 100)) return concat("square must be above 0 and below 100 m, got ", square);
  if ((columns + rows) % 2 == 0)
    return concat(
        "a board of ", columns, "x", rows,
        " inner corners looks the same after half a turn, so that both cameras may count its corners "
        "from different ends; use one with an odd and an even number, such as 9x6");
  return {};
}

Board parse_board(const std::string& text, double square) {
  const std::size_t cross = text.find('x');
  long columns = 0, rows = 0;
  if (cross == std::string::npos || !parse_integer(std::string_view(text).substr(0, cross), columns) ||
      !parse_integer(std::string_view(text).substr(cross + 1), rows) || columns < 1 || rows < 1 ||
      columns > 1000 || rows > 1000)
    throw InvalidInput(
        concat("'", text, "' is no board; give the inner corners along both sides, such as 9x6"));
  return {.columns = static_cast<int>(columns), .rows = static_cast<int>(rows), .square = square};
}

int BoardPair::n_common() const {
  int n = 0;
  for (int i = 0; i < static_cast<int>(left.rows()); ++i) n += in_both(i) ? 1 : 0;
  return n;
}

std::optional<std::string> problem(const BoardPairs& pairs) {
  if (auto found = pairs.board.problem()) return found;
  if (pairs.left_width < 1 || pairs.left_height < 1 || pairs.right_width < 1 || pairs.right_height < 1)
    return "the sizes of the images must be at least 1 pixel";
  const auto check = [&](const BoardPair& pair, const BoardCorners& corners, const char* side, int width,
                         int height) -> std::optional<std::string> {
    if (corners.rows() != pairs.board.n_corners())
      return concat("pair ", pair.number, " has ", corners.rows(), " corners in the ", side,
                    " image; the board has ", pairs.board.n_corners());
    for (Eigen::Index i = 0; i < corners.rows(); ++i)
      if (corners.row(i).allFinite() &&
          !(corners(i, 0) >= 0 && corners(i, 0) <= width && corners(i, 1) >= 0 && corners(i, 1) <= height))
        return concat("corner ", i, " of pair ", pair.number, " lies outside of the ", side, " image of ",
                      width, " x ", height, " pixels");
    return {};
  };
  for (const BoardPair& pair : pairs.pairs) {
    if (auto found = check(pair, pair.left, "left", pairs.left_width, pairs.left_height)) return found;
    if (auto found = check(pair, pair.right, "right", pairs.right_width, pairs.right_height)) return found;
  }
  return {};
}

}  // namespace batten
