#include "batten/simulation/simulate_boards.hpp"

#include <algorithm>
#include <cmath>

#include "batten/camera/pen.hpp"
#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

constexpr int kTriesPerPair = 2000;
constexpr double kMostTurn = 0.5;            // radians, of the board in its plane
constexpr std::uint64_t kBoardStream = 401;  // of random numbers

/// The board at one place; false where a corner is outside of an image.
bool show_board(const StereoRig& rig, const Board& board, const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                BoardPair& pair) {
  const Eigen::Vector3d middle = (board.corner(0) + board.corner(board.n_corners() - 1)) / 2;
  for (int corner = 0; corner < board.n_corners(); ++corner) {
    const Eigen::Vector3d point = R * (board.corner(corner) - middle) + t;
    const auto left = image_in(rig, CameraSide::Left, point), right = image_in(rig, CameraSide::Right, point);
    if (!left || !right || !is_inside(rig.left, *left) || !is_inside(rig.right, *right)) return false;
    pair.left.row(corner) = left->transpose();
    pair.right.row(corner) = right->transpose();
  }
  return true;
}

}  // namespace

std::optional<std::string> SimulateBoardsOptions::problem() const {
  const auto range = [](const char* field, double value, const char* expected) {
    return concat(field, " is ", value, "; expected ", expected);
  };
  if (const auto found = board.problem()) return "board: " + *found;
  if (pairs < 1 || pairs > 1000) return range("pairs", pairs, "1 to 1000");
  if (!(noise >= 0 && noise <= 10)) return range("noise", noise, "0 to 10 pixels");
  if (!(nearest > 0)) return range("nearest", nearest, "metres above 0");
  if (!(farthest > nearest)) return range("farthest", farthest, "more than nearest");
  if (!(largest_tilt >= 0 && largest_tilt <= 1.2)) return range("largest_tilt", largest_tilt, "0 to 1.2 rad");
  return {};
}

BoardPairs simulate_boards(const StereoRig& rig, const SimulateBoardsOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  if (const std::string found = problem(rig); !found.empty()) throw InvalidInput("rig: " + found);
  BoardPairs result{options.board, rig.left.width, rig.left.height, rig.right.width, rig.right.height, {}};
  Random random(options.seed, kBoardStream);
  const double half_u = rig.left.width / 2.0 / rig.left.fx, half_v = rig.left.height / 2.0 / rig.left.fy;
  for (int number = 1; number <= options.pairs; ++number) {
    BoardPair pair;
    pair.number = number;
    pair.left.resize(options.board.n_corners(), 2);
    pair.right.resize(options.board.n_corners(), 2);
    bool shown = false;
    for (int attempt = 0; attempt < kTriesPerPair && !shown; ++attempt) {
      const double about = random.uniform(-kPi, kPi);
      const double tilt = random.uniform(-options.largest_tilt, options.largest_tilt);
      const Eigen::Matrix3d R = so3_exp(tilt * Eigen::Vector3d(std::cos(about), std::sin(about), 0)) *
                                so3_exp(Eigen::Vector3d(0, 0, random.uniform(-kMostTurn, kMostTurn)));
      const double z = random.uniform(options.nearest, options.farthest);
      const double u = random.uniform(-half_u, half_u), v = random.uniform(-half_v, half_v);
      shown = show_board(rig, options.board, R, {u * z, v * z, z}, pair);
    }
    if (!shown)
      throw InvalidInput(concat("both cameras nowhere see the whole board of ", options.board.columns, " x ",
                                options.board.rows, " corners; take a smaller one"));
    for (BoardCorners* corners : {&pair.left, &pair.right})
      for (Eigen::Index i = 0; i < corners->rows(); ++i)
        for (int k = 0; k < 2; ++k) {
          // A detector finds no corner outside of the image.
          const double most = k == 0 ? result.left_width : result.left_height;
          (*corners)(i, k) = std::clamp((*corners)(i, k) + options.noise * random.normal(), 0.0, most);
        }
    result.pairs.push_back(std::move(pair));
  }
  return result;
}

}  // namespace batten
