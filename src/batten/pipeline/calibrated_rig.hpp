#pragma once
#include <string>
#include <vector>

#include "batten/camera/calibration.hpp"
#include "batten/camera/chessboard.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"

namespace batten {

/// An image of a board, and where it belongs.
struct BoardPhotograph {
  std::string name;  ///< for sentences: that of its file
  int pair = 0;
  bool is_right = false;
  GreyImage image;
};

/// Pairs of boards found in images, and why others were not.
struct FoundBoards {
  BoardPairs pairs;
  std::vector<std::string> warnings;  ///< images without their other one, or in which no board was found
};

/// Finds the board in all images: find_chessboard(), on all threads. Pairs without it in either image are
/// left out with a warning.
/// @throws InvalidInput when images of one camera differ in size, two are of one pair and side, or fewer than
/// 4 pairs remain, with what was wrong with the others; Cancelled.
FoundBoards boards_in_images(const std::vector<BoardPhotograph>& photographs, const Board& board,
                             const ChessboardOptions& options = {}, const Progress& progress = {});

/// A calibrated rig, checked against the pairs that it was calibrated from.
struct CalibratedRigRun {
  RigCalibration calibration;
  RigCheck check;                     ///< of all pairs given; see check_rig()
  std::vector<std::string> warnings;  ///< pairs and corners left out; figures that are worse than usual
  StageTimes times;
};

/// Calibrates a rig and checks it: calibrate_rig(), check_rig().
///
/// Warned of are, beside what calibrate_rig() leaves out: a focal length known to less than 1 %, corners that
/// lie more than 1 pixel (rms) from their projections, and an image of which less than half was covered.
/// @throws InvalidInput as calibrate_rig(); Cancelled.
CalibratedRigRun calibrated_rig(const BoardPairs& pairs, const RigCalibrationOptions& options = {},
                                const Progress& progress = {});

}  // namespace batten
