#include "batten/simulation/simulate_boards.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/simulation/pen.hpp"

namespace batten {
namespace {

// Corners are images of one flat board: of two cameras they meet its epipolar lines, within their errors.
TEST(SimulateBoards, CornersBelongTogether) {
  for (const PenRig kind : {PenRig::Wiimote, PenRig::Vga, PenRig::Global}) {
    const StereoRig rig = nominal_rig(kind);
    for (const double noise : {0.0, 0.2}) {
      const BoardPairs pairs = simulate_boards(rig, {.pairs = 5, .noise = noise, .seed = 3});
      ASSERT_EQ(pairs.pairs.size(), 5u);
      EXPECT_FALSE(problem(pairs)) << *problem(pairs);
      double squares = 0, n = 0;
      for (const BoardPair& pair : pairs.pairs)
        for (Eigen::Index i = 0; i < pair.left.rows(); ++i, ++n)
          squares += std::pow(*epipolar_distance(rig, pair.left.row(i), pair.right.row(i)), 2);
      // Either point is off its line by the errors of both, about √2 σ.
      EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(2.0) * noise, 0.15 * noise + 1e-9) << word_of(kind);
    }
  }
}

TEST(SimulateBoards, RefusesWhatCannotBeShown) {
  const StereoRig rig = nominal_rig(PenRig::Vga);
  EXPECT_THROW(simulate_boards(rig, {.pairs = 0}), InvalidInput);
  EXPECT_THROW(simulate_boards(rig, {.noise = -1}), InvalidInput);
  SimulateBoardsOptions large;
  large.board.square = 1;
  EXPECT_THROW(simulate_boards(rig, large), InvalidInput);
}

}  // namespace
}  // namespace batten
