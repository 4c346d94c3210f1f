#include <cmath>

#include <Eigen/Geometry>

#include "batten/camera/calibration.hpp"
#include "batten/camera/triangulation.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"

namespace batten {

namespace {

/// Sums of a quantity, for its mean and deviation.
struct Sums {
  double sum = 0, squares = 0;
  int n = 0;

  void add(double value) {
    sum += value;
    squares += value * value;
    ++n;
  }
  double mean() const { return n > 0 ? sum / n : 0; }
  double rms() const { return n > 0 ? std::sqrt(squares / n) : 0; }
};

/// Mean square distance of points to those of the board laid upon them by a rigid motion.
double rigid_misfit(const Board& board, const std::vector<std::optional<Eigen::Vector3d>>& points) {
  Eigen::Matrix3Xd from(3, 0), to(3, 0);
  for (int i = 0; i < board.n_corners(); ++i) {
    if (!points[at(i)]) continue;
    from.conservativeResize(3, from.cols() + 1);
    to.conservativeResize(3, to.cols() + 1);
    from.rightCols<1>() = board.corner(i);
    to.rightCols<1>() = *points[at(i)];
  }
  if (from.cols() < 3) return 0;
  const Eigen::Matrix4d motion = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3Xd laid = (motion.topLeftCorner<3, 3>() * from).colwise() + motion.col(3).head<3>();
  return (laid - to).squaredNorm() / static_cast<double>(from.cols());
}

}  // namespace

RigCheck check_rig(const StereoRig& rig, const BoardPairs& pairs) {
  if (const std::string found = problem(rig); !found.empty()) throw InvalidInput(found);
  if (const auto found = problem(pairs)) throw InvalidInput(*found);
  const Board& board = pairs.board;
  RigCheck check;
  Sums epipolar, rigid;
  std::vector<double> neighbours;
  for (const BoardPair& pair : pairs.pairs) {
    std::vector<std::optional<Eigen::Vector3d>> points(at(board.n_corners()));
    Sums of_pair;
    for (int i = 0; i < board.n_corners(); ++i) {
      if (!pair.in_both(i)) continue;
      const Eigen::Vector2d left = pair.left.row(i).transpose(), right = pair.right.row(i).transpose();
      const auto distance = epipolar_distance(rig, left, right);
      const auto point = triangulate(rig, left, right);
      if (!distance || !point) {
        ++check.lost;
        continue;
      }
      of_pair.add(*distance);
      epipolar.add(*distance);
      points[at(i)] = point->position;
    }
    if (of_pair.n == 0) continue;
    const auto add_neighbours = [&](int i, int k) {
      if (points[at(i)] && points[at(k)])
        neighbours.push_back((*points[at(i)] - *points[at(k)]).norm() / board.square);
    };
    for (int i = 0; i < board.n_corners(); ++i) {
      if (i % board.columns + 1 < board.columns) add_neighbours(i, i + 1);
      if (i + board.columns < board.n_corners()) add_neighbours(i, i + board.columns);
    }
    PairFigures figures;
    figures.number = pair.number;
    figures.epipolar = of_pair.mean();
    const double misfit = rigid_misfit(board, points);
    figures.rms = std::sqrt(misfit) / board.square;
    rigid.sum += misfit * of_pair.n;
    rigid.n += of_pair.n;
    check.each.push_back(figures);
  }
  if (epipolar.n == 0)
    throw InvalidInput("no corner was seen by both cameras, so there is nothing to check the rig with");
  check.pairs = static_cast<int>(check.each.size());
  check.corners = epipolar.n;
  check.epipolar = epipolar.mean();
  check.epipolar_rms = epipolar.rms();
  check.rigid_rms = std::sqrt(rigid.mean()) / board.square;
  Sums lengths, spread;
  for (const double length : neighbours) lengths.add(length);
  check.neighbour_mean = lengths.mean();
  for (const double length : neighbours) spread.add(length - lengths.mean());
  check.neighbour_std = spread.rms();
  return check;
}

}  // namespace batten
