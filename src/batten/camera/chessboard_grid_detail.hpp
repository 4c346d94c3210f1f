#pragma once
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/saddle_points_detail.hpp"

// Growing of grids of saddle points; not part of the library's interface.
namespace batten::detail {

/// Places of corners by (column, row), counted from the seed.
class SaddleGrid {
 public:
  using Cell = std::pair<int, int>;

  /// Grows from a square of four saddle points, (0, 0), (1, 0), (0, 1) and (1, 1), until nothing fits any
  /// more or `most` corners are reached.
  SaddleGrid(const SmoothImage& image, const Eigen::Vector2d (&square)[4], int most);

  const std::map<Cell, Eigen::Vector2d>& cells() const { return cells_; }
  /// Corners along both directions.
  int columns() const;
  int rows() const;

 private:
  std::optional<Eigen::Vector2d> grown(const Cell& from, const Cell& step) const;
  /// A side at a corner across the given one; where there is none yet, perpendicular to it.
  Eigen::Vector2d across_side(const Cell& from, const Cell& step, const Eigen::Vector2d& side) const;
  const Eigen::Vector2d* find(int column, int row) const;

  const SmoothImage& image_;
  std::map<Cell, Eigen::Vector2d> cells_;
  double least_edge_ = 0;  ///< difference across a side below which it is none, grey levels
};

/// How much brighter it is on the left of the way from a to b than on its right (x right, y down), a quarter
/// of its length away: near zero unless it is a side between a dark and a bright square.
double edge_difference(const SmoothImage& image, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// The first square of four saddle points that includes `seed`, or nothing: neighbours such that all four
/// sides are edges and turn from dark to bright alternately.
std::optional<std::vector<Eigen::Vector2d>> square_at(const SmoothImage& image,
                                                      const std::vector<SaddlePoint>& points,
                                                      std::size_t seed, double least_edge);

}  // namespace batten::detail
