#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "batten/camera/board.hpp"
#include "batten/camera/rig.hpp"

namespace batten {

/// How a chessboard is shown to two cameras.
struct SimulateBoardsOptions {
  Board board{};
  int pairs = 20;                       ///< 1 to 1000
  double noise = 0.1;                   ///< of a corner, standard deviation per coordinate, pixels
  double nearest = 0.35, farthest = 1;  ///< of the middle of the board from the left camera, metres
  double largest_tilt = 0.7;            ///< of the board against the image, radians, 0 to 1.2
  std::uint64_t seed = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Corners of a board at random places and tilts where both cameras see all of it, with normal errors:
/// what a rig is calibrated from (calibrate_rig()).
/// @throws InvalidInput on bad options or rig, and where no place is found at which both cameras see the
/// whole board.
BoardPairs simulate_boards(const StereoRig& rig, const SimulateBoardsOptions& options = {});

}  // namespace batten
