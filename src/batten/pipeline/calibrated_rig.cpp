#include "batten/pipeline/calibrated_rig.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

void add_warnings(CalibratedRigRun& run) {
  constexpr double kUnsureFocalLength = 0.01;
  constexpr double kPoorFit = 1.0;  // pixels
  constexpr double kPoorCoverage = 0.5;
  const StereoRig& rig = run.calibration.calibrated.rig;
  const RigFigures& figures = run.calibration.calibrated.figures;
  run.warnings = run.calibration.warnings;
  const double unsure =
      std::max(figures.deviations.left.fx / rig.left.fx, figures.deviations.right.fx / rig.right.fx);
  if (unsure > kUnsureFocalLength)
    run.warnings.push_back(concat("the focal length is known to ", 100 * unsure,
                                  " % only; more pairs with the board tilted by 20 to 40 degrees help"));
  if (figures.rms > kPoorFit)
    run.warnings.push_back(
        concat("corners lie ", figures.rms,
               " pixels (rms) from where the rig sees them; is the board flat, and were both "
               "images taken at one time?"));
  for (const bool right : {false, true})
    if (const double share = right ? figures.right_coverage : figures.left_coverage; share < kPoorCoverage)
      run.warnings.push_back(concat("the board covers ", std::lround(100 * share), " % of the ",
                                    right ? "right" : "left",
                                    " image over all pairs; the distortion outside is a guess"));
}

/// The photographs of every pair, left and right.
std::map<int, std::array<const BoardPhotograph*, 2>> by_pair(
    const std::vector<BoardPhotograph>& photographs) {
  std::map<int, std::array<const BoardPhotograph*, 2>> pairs;
  std::array<const BoardPhotograph*, 2> first{};
  for (const BoardPhotograph& each : photographs) {
    const std::size_t side = each.is_right ? 1 : 0;
    const BoardPhotograph*& place = pairs[each.pair][side];
    if (place != nullptr)
      throw InvalidInput(concat(place->name, " and ", each.name, " are both the ",
                                each.is_right ? "right" : "left", " image of pair ", each.pair));
    place = &each;
    if (first[side] == nullptr) first[side] = &each;
    const GreyImage& one = first[side]->image;
    if (one.width != each.image.width || one.height != each.image.height)
      throw InvalidInput(concat(each.name, " has ", each.image.width, " x ", each.image.height,
                                " pixels and ", first[side]->name, " ", one.width, " x ", one.height,
                                "; all images of one camera must have one size"));
  }
  return pairs;
}

}  // namespace

FoundBoards boards_in_images(const std::vector<BoardPhotograph>& photographs, const Board& board,
                             const ChessboardOptions& options, const Progress& progress) {
  constexpr std::size_t kFewest = 4;
  if (const auto found = board.problem()) throw InvalidInput(*found);
  if (const auto found = options.problem()) throw InvalidInput(*found);
  const auto pairs = by_pair(photographs);
  std::vector<ChessboardSearch> searches(photographs.size());
  parallel_for(
      static_cast<Eigen::Index>(photographs.size()), 1,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i)
          searches[at(i)] = find_chessboard(photographs[at(i)].image, board, options);
      },
      progress);
  const auto search_of = [&](const BoardPhotograph* photograph) -> const ChessboardSearch& {
    return searches[static_cast<std::size_t>(photograph - photographs.data())];
  };
  FoundBoards result;
  result.pairs.board = board;
  for (const auto& [number, sides] : pairs) {
    if (sides[0] == nullptr || sides[1] == nullptr) {
      const bool has_left = sides[0] != nullptr;
      result.warnings.push_back(concat(sides[has_left ? 0 : 1]->name, " is left out: there is no ",
                                       has_left ? "right" : "left", " image of pair ", number));
      continue;
    }
    bool is_found = true;
    for (const BoardPhotograph* side : sides) {
      if (search_of(side).corners) continue;
      result.warnings.push_back(concat(side->name, " is left out: ", search_of(side).reason));
      is_found = false;
    }
    if (!is_found) continue;
    result.pairs.left_width = sides[0]->image.width;
    result.pairs.left_height = sides[0]->image.height;
    result.pairs.right_width = sides[1]->image.width;
    result.pairs.right_height = sides[1]->image.height;
    result.pairs.pairs.push_back({number, *search_of(sides[0]).corners, *search_of(sides[1]).corners});
  }
  if (result.pairs.pairs.size() >= kFewest) return result;
  std::string reasons;
  for (const std::string& warning : result.warnings) reasons += concat("\n  ", warning);
  throw InvalidInput(concat("a rig needs at least ", kFewest, " pairs of images with the whole board, ",
                            result.pairs.pairs.size(), " of ", pairs.size(), " can be used", reasons));
}

CalibratedRigRun calibrated_rig(const BoardPairs& pairs, const RigCalibrationOptions& options,
                                const Progress& progress) {
  CalibratedRigRun run;
  {
    const ScopedStage stage(run.times, "calibrate");
    run.calibration = calibrate_rig(pairs, options, progress);
  }
  {
    const ScopedStage stage(run.times, "check");
    run.check = check_rig(run.calibration.calibrated.rig, pairs);
  }
  add_warnings(run);
  return run;
}

}  // namespace batten
