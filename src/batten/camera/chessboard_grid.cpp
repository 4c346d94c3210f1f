#include <algorithm>
#include <cmath>

#include "batten/camera/chessboard_grid_detail.hpp"

namespace batten::detail {

namespace {

/// How far a corner may lie from where its neighbours predict it, in sides.
constexpr double kPredictionError = 0.3;
/// Share of the contrast of the seed that every side must have: shade and gloss vary over a board.
constexpr double kLeastShare = 0.3;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Of the window in which the corner is refined while the grid grows.
double window(const SmoothImage& image, double side) {
  return std::clamp(0.25 * side, 2.0, std::max(3.0, 2.5 * image.sigma()));
}

/// Whether both quadrants between `s` and `t` are brighter, or both darker, than the two others: not where
/// the board ends, or where a side meets something else.
bool is_crossing(const SmoothImage& image, const Eigen::Vector2d& p, const Eigen::Vector2d& s,
                 const Eigen::Vector2d& t, double least) {
  constexpr double kShare = 0.3;
  const Eigen::Vector2d a = kShare * (s + t), b = kShare * (s - t);
  const auto [dark, bright] = std::minmax({image.sample(p + a), image.sample(p - a)});
  const auto [other_dark, other_bright] = std::minmax({image.sample(p + b), image.sample(p - b)});
  return dark - other_bright >= least || other_dark - bright >= least;
}

}  // namespace

double edge_difference(const SmoothImage& image, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d way = b - a, left(way.y() / 4, -way.x() / 4), middle = (a + b) / 2;
  return image.sample(middle + left) - image.sample(middle - left);
}

std::optional<std::vector<Eigen::Vector2d>> square_at(const SmoothImage& image,
                                                      const std::vector<SaddlePoint>& points,
                                                      std::size_t seed, double least_edge) {
  constexpr std::size_t kNeighbours = 12;
  const Eigen::Vector2d p = points[seed].place;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i != seed) near.push_back(i);
  const auto distance = [&](std::size_t i) { return (points[i].place - p).squaredNorm(); };
  const std::size_t n = std::min(kNeighbours, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(n), near.end(),
                    [&](std::size_t i, std::size_t k) { return distance(i) < distance(k); });
  near.resize(n);
  for (const std::size_t i : near) {
    const Eigen::Vector2d q = points[i].place, along = q - p;
    const double first = edge_difference(image, p, q);
    if (std::abs(first) < least_edge) continue;
    for (const std::size_t k : near) {
      const Eigen::Vector2d r = points[k].place, down = r - p;
      const double ratio = down.norm() / along.norm();
      // A right-handed corner, not too flat (x right, y down: down is clockwise of along).
      if (ratio < 0.4 || ratio > 2.5 || cross(along, down) < 0.5 * along.norm() * down.norm()) continue;
      // The square that both sides bound is on the right of one and on the left of the other.
      const double second = edge_difference(image, p, r);
      if (std::abs(second) < least_edge || (second > 0) == (first > 0)) continue;
      const auto fourth = saddle_near(image, q + r - p, window(image, std::min(along.norm(), down.norm())));
      if (!fourth) continue;
      const Eigen::Vector2d s = fourth->place;
      if ((s - (q + r - p)).norm() > kPredictionError * std::min(along.norm(), down.norm())) continue;
      const double third = edge_difference(image, r, s), last = edge_difference(image, q, s);
      if (std::abs(third) < least_edge || std::abs(last) < least_edge) continue;
      if ((third > 0) == (first > 0) || (last > 0) == (second > 0)) continue;
      const bool all =
          is_crossing(image, p, along, down, least_edge) && is_crossing(image, q, along, down, least_edge) &&
          is_crossing(image, r, along, down, least_edge) && is_crossing(image, s, along, down, least_edge);
      if (all) return std::vector<Eigen::Vector2d>{p, q, r, s};
    }
  }
  return {};
}

SaddleGrid::SaddleGrid(const SmoothImage& image, const Eigen::Vector2d (&square)[4], int most)
    : image_(image) {
  cells_[{0, 0}] = square[0];
  cells_[{1, 0}] = square[1];
  cells_[{0, 1}] = square[2];
  cells_[{1, 1}] = square[3];
  least_edge_ = kLeastShare * std::abs(edge_difference(image, square[0], square[1]));
  constexpr Cell kSteps[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  // In rings: a corner is predicted from its nearest neighbours, which were found before it.
  for (bool is_growing = true; is_growing;) {
    is_growing = false;
    std::vector<Cell> known;
    for (const auto& [cell, place] : cells_) known.push_back(cell);
    for (const Cell& cell : known)
      for (const Cell& step : kSteps) {
        const Cell next{cell.first + step.first, cell.second + step.second};
        if (cells_.count(next) != 0) continue;
        const auto place = grown(cell, step);
        if (!place) continue;
        cells_[next] = *place;
        is_growing = true;
        if (static_cast<int>(cells_.size()) >= most) return;
      }
  }
}

const Eigen::Vector2d* SaddleGrid::find(int column, int row) const {
  const auto place = cells_.find({column, row});
  return place == cells_.end() ? nullptr : &place->second;
}

Eigen::Vector2d SaddleGrid::across_side(const Cell& from, const Cell& step,
                                        const Eigen::Vector2d& side) const {
  const Eigen::Vector2d p = *find(from.first, from.second);
  for (const int across : {-1, 1})
    if (const auto* q = find(from.first + across * step.second, from.second + across * step.first))
      return *q - p;
  return {-side.y(), side.x()};
}

std::optional<Eigen::Vector2d> SaddleGrid::grown(const Cell& from, const Cell& step) const {
  const Eigen::Vector2d p = *find(from.first, from.second);
  Eigen::Vector2d side = Eigen::Vector2d::Zero();
  int n = 0;
  const auto add = [&](const Eigen::Vector2d* a, const Eigen::Vector2d* b) {
    if (a == nullptr || b == nullptr) return;
    side += *b - *a;
    ++n;
  };
  // Sides that should be like the wanted one: the one before it, and those of both neighbouring rows.
  add(find(from.first - step.first, from.second - step.second), &p);
  for (const int across : {-1, 1}) {
    const Cell a{from.first + across * step.second, from.second + across * step.first};
    add(find(a.first, a.second), find(a.first + step.first, a.second + step.second));
  }
  if (n == 0) return {};
  side /= n;
  const auto point = saddle_near(image_, p + side, window(image_, side.norm()));
  if (!point || (point->place - (p + side)).norm() > kPredictionError * side.norm()) return {};
  const double edge = edge_difference(image_, p, point->place);
  if (std::abs(edge) < least_edge_) return {};
  // Dark and bright change places from side to side, along the row as across it.
  if (const auto* before = find(from.first - step.first, from.second - step.second))
    if ((edge_difference(image_, *before, p) > 0) == (edge > 0)) return {};
  for (const int across : {-1, 1}) {
    const Cell a{from.first + across * step.second, from.second + across * step.first};
    const auto* q = find(a.first, a.second);
    const auto* r = find(a.first + step.first, a.second + step.second);
    if (q != nullptr && r != nullptr && (edge_difference(image_, *q, *r) > 0) == (edge > 0)) return {};
  }
  if (!is_crossing(image_, point->place, side, across_side(from, step, side), least_edge_)) return {};
  for (const auto& [cell, place] : cells_)
    if ((place - point->place).norm() < 0.5 * side.norm()) return {};  // found before, under another number
  return point->place;
}

int SaddleGrid::columns() const {
  const auto [least, most] =
      std::minmax_element(cells_.begin(), cells_.end(),
                          [](const auto& a, const auto& b) { return a.first.first < b.first.first; });
  return most->first.first - least->first.first + 1;
}

int SaddleGrid::rows() const {
  const auto [least, most] =
      std::minmax_element(cells_.begin(), cells_.end(),
                          [](const auto& a, const auto& b) { return a.first.second < b.first.second; });
  return most->first.second - least->first.second + 1;
}

}  // namespace batten::detail
