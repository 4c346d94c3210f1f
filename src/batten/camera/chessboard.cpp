#include "batten/camera/chessboard.hpp"

#include <algorithm>
#include <cmath>

#include "batten/camera/chessboard_grid_detail.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

using detail::SaddleGrid;
using detail::SaddlePoint;
using detail::SmoothImage;

/// Blurs of the image in which the board is looked for, pixels: the finest sees the smallest squares, the
/// coarser ones see less grain.
constexpr double kBlurs[] = {1.2, 2.0, 3.5};
/// Blur in which corners are placed; see docs/rig.md for the windows tried.
constexpr double kFinalBlur = 1.5;
constexpr double kAlwaysSharp = 2.0;  // pixels

/// A grid counted as the board is, with the number of corners it has.
struct Found {
  std::vector<Eigen::Vector2d> corners;  ///< by index of the board; empty unless all are there
  int n = 0, columns = 0, rows = 0;      ///< of the grid
};

/// The corners of the only full rectangle of the board's size in the grid, as it lies (`is_turned`: on its
/// side), counted so that columns and rows turn as x and y of the image do. Empty where there is none, or
/// more.
std::vector<Eigen::Vector2d> full_rectangle(const SaddleGrid& grid, const Board& board, bool is_turned) {
  const int width = is_turned ? board.rows : board.columns, height = is_turned ? board.columns : board.rows;
  std::vector<Eigen::Vector2d> corners;
  for (const auto& [first, place] : grid.cells()) {
    std::vector<Eigen::Vector2d> rectangle(at(board.n_corners()));
    bool is_full = true;
    for (int y = 0; y < height && is_full; ++y)
      for (int x = 0; x < width && is_full; ++x) {
        const auto cell = grid.cells().find({first.first + x, first.second + y});
        is_full = cell != grid.cells().end();
        if (!is_full) break;
        // A quarter of a turn keeps the sense of columns and rows.
        const int column = is_turned ? y : x, row = is_turned ? width - 1 - x : y;
        rectangle[at(row * board.columns + column)] = cell->second;
      }
    if (!is_full) continue;
    if (!corners.empty()) return {};
    corners = std::move(rectangle);
  }
  return corners;
}

Found ordered(const SmoothImage& image, const SaddleGrid& grid, const Board& board) {
  Found found{{}, static_cast<int>(grid.cells().size()), grid.columns(), grid.rows()};
  // Something beyond the border may look like a corner; a board with many more is another one.
  constexpr double kMostBeyond = 0.1;
  if (found.n > (1 + kMostBeyond) * board.n_corners()) return found;
  std::vector<Eigen::Vector2d> upright = full_rectangle(grid, board, false);
  std::vector<Eigen::Vector2d> turned = full_rectangle(grid, board, true);
  if (upright.empty() == turned.empty()) return found;
  found.corners = upright.empty() ? std::move(turned) : std::move(upright);
  // The first square is dark, and so is the one beyond the first corner, which touches it there.
  if (detail::edge_difference(image, found.corners[0], found.corners[1]) < 0)
    std::reverse(found.corners.begin(), found.corners.end());
  return found;
}

/// The grid with the most corners, from the strongest seeds.
Found best_grid(const SmoothImage& image, const Board& board, double contrast) {
  constexpr std::size_t kMostSeeds = 60;
  const std::vector<SaddlePoint> points = detail::saddle_points(image, contrast / 2);
  Found best;
  for (std::size_t seed = 0; seed < std::min(kMostSeeds, points.size()); ++seed) {
    const auto square = detail::square_at(image, points, seed, contrast / 2);
    if (!square) continue;
    const Eigen::Vector2d corners[4] = {(*square)[0], (*square)[1], (*square)[2], (*square)[3]};
    Found found = ordered(image, SaddleGrid(image, corners, 2 * board.n_corners()), board);
    if (!found.corners.empty()) return found;
    if (found.n > best.n) best = std::move(found);
  }
  return best;
}

/// Of the sides to the next columns and rows.
struct Sides {
  Eigen::Vector2d along, down;
  double shortest() const { return std::min(along.norm(), down.norm()); }
};

Sides sides_at(const std::vector<Eigen::Vector2d>& corners, const Board& board, int index) {
  const int column = index % board.columns, row = index / board.columns;
  const auto place = [&](int c, int r) {
    return corners[at(std::clamp(r, 0, board.rows - 1) * board.columns +
                      std::clamp(c, 0, board.columns - 1))];
  };
  const double across = column > 0 && column + 1 < board.columns ? 2 : 1;
  const double below = row > 0 && row + 1 < board.rows ? 2 : 1;
  return {(place(column + 1, row) - place(column - 1, row)) / across,
          (place(column, row + 1) - place(column, row - 1)) / below};
}

/// Half the difference of bright and dark around a corner, a third of a square away from it.
double contrast_around(const SmoothImage& image, const Eigen::Vector2d& corner, const Sides& sides) {
  constexpr double kShare = 0.35;
  const Eigen::Vector2d a = kShare * (sides.along + sides.down), b = kShare * (sides.along - sides.down);
  return std::abs(image.sample(corner + a) + image.sample(corner - a) - image.sample(corner + b) -
                  image.sample(corner - b)) /
         4;
}

/// Blur of the image itself: a corner of contrast c, blurred by τ in all, has the mixed derivative c · 2 / (π
/// τ²) along its sides.
double blur_around(const SmoothImage& image, const Eigen::Vector2d& corner, const Sides& sides,
                   double contrast) {
  const Eigen::Vector2d s = sides.along.normalized(), t = sides.down.normalized();
  const double mixed = std::abs(image.sample(corner + s + t) - image.sample(corner + s - t) -
                                image.sample(corner - s + t) + image.sample(corner - s - t)) /
                       4;
  if (!(mixed > 0)) return sides.shortest();
  return std::sqrt(std::max(0.0, contrast * 2 / (kPi * mixed) - image.sigma() * image.sigma()));
}

/// Places the corners exactly, and measures contrast and blur.
void refine(const GreyImage& given, const Board& board, const ChessboardOptions& options, const Found& found,
            ChessboardSearch& search) {
  const SmoothImage image(given, kFinalBlur);
  BoardCorners corners(board.n_corners(), 2);
  std::vector<double> contrasts, blurs, lengths;
  for (int i = 0; i < board.n_corners(); ++i) {
    const Sides sides = sides_at(found.corners, board, i);
    const double side = sides.shortest();
    const auto point = detail::saddle_near(image, found.corners[at(i)], std::clamp(0.3 * side, 2.5, 6.0));
    if (!point || (point->place - found.corners[at(i)]).norm() > 0.3 * side) {
      search.reason = concat("corner (", i % board.columns, ", ", i / board.columns,
                             ") of the board is not clear enough; take the picture again with even light");
      return;
    }
    corners.row(i) = point->place.transpose();
    contrasts.push_back(contrast_around(image, point->place, sides));
    blurs.push_back(blur_around(image, point->place, sides, contrasts.back()));
    lengths.push_back(side);
  }
  search.contrast = median(contrasts);
  search.blur = median(blurs);
  const double limit = std::max(kAlwaysSharp, options.blur * median(lengths));
  if (search.contrast < options.contrast)
    search.reason = concat("the image is too dark: bright and dark squares differ by ", 2 * search.contrast,
                           " grey levels, at least ", 2 * options.contrast,
                           " are needed; use more light or a longer exposure");
  else if (search.blur > limit)
    search.reason = concat("the image is blurred by ", search.blur, " pixels, at most ", limit,
                           " are good enough; hold the board still, and focus");
  else
    search.corners = corners;
}

}  // namespace

std::optional<std::string> ChessboardOptions::problem() const {
  if (!(contrast >= 2 && contrast <= 127)) return concat("contrast must be 2 to 127, got ", contrast);
  if (!(blur >= 0.01 && blur <= 0.5)) return concat("blur must be 0.01 to 0.5, got ", blur);
  return {};
}

ChessboardSearch find_chessboard(const GreyImage& image, const Board& board,
                                 const ChessboardOptions& options) {
  if (const auto found = board.problem()) throw InvalidInput(*found);
  if (const auto found = options.problem()) throw InvalidInput(*found);
  ChessboardSearch search;
  Found best;
  for (const double blur : kBlurs) {
    Found found = best_grid(SmoothImage(image, blur), board, options.contrast);
    if (found.n > best.n || !found.corners.empty()) best = std::move(found);
    if (!best.corners.empty()) break;
  }
  if (!best.corners.empty())
    refine(image, board, options, best, search);
  else if (best.n == 0)
    search.reason = "no chessboard was found; is the image dark or blurred, or the board outside of it?";
  else
    search.reason = concat("a grid of ", best.columns, "x", best.rows, " with ", best.n,
                           " corners was found, the board has ", board.columns, "x", board.rows,
                           "; show all of it, with even light and a white margin");
  return search;
}

}  // namespace batten
