#include "batten/camera/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/camera/board_poses_detail.hpp"
#include "batten/camera/rig_adjustment_detail.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

using detail::Adjustment;
using detail::BoardPose;
using detail::RigState;
using detail::Sighting;

constexpr int kFewestPairs = 4;
constexpr int kFewestCorners = 12;
constexpr double kLeastCoverage = 0.3;
constexpr double kLeastTilt = radians(10.0);
/// Both cameras see one board: the turn between them is the same in every pair but for the errors of first
/// guesses, some degrees. A board read from its other end is off by half a turn.
constexpr double kOtherOrder = radians(45.0);
constexpr int kMostFolds = 12;

/// What is carried from step to step.
struct Work {
  const BoardPairs& given;
  const RigCalibrationOptions& options;
  std::vector<const BoardPair*> pairs;  ///< usable ones
  RigState start;
  RigCalibration result;
};

/// Homographies of the pairs that can be used; the others are left out with a warning.
struct Views {
  std::vector<Eigen::Matrix3d> left, right;
};

Views usable_views(Work& work) {
  Views views;
  for (const BoardPair& pair : work.given.pairs) {
    const int common = pair.n_common();
    if (common < kFewestCorners) {
      work.result.warnings.push_back(concat("pair ", pair.number, " is left out: both cameras see ", common,
                                            " corners of its board, at least ", kFewestCorners,
                                            " are needed"));
      continue;
    }
    const auto left = detail::homography(work.given.board, pair.left);
    const auto right = detail::homography(work.given.board, pair.right);
    if (!left || !right) {
      work.result.warnings.push_back(
          concat("pair ", pair.number, " is left out: its corners lie nearly on one line"));
      continue;
    }
    work.pairs.push_back(&pair);
    views.left.push_back(*left);
    views.right.push_back(*right);
  }
  return views;
}

void check_number(const Work& work) {
  if (work.pairs.size() >= at(kFewestPairs)) return;
  std::string reasons;
  for (const std::string& warning : work.result.warnings) reasons += concat(" (", warning, ")");
  throw InvalidInput(concat("a rig needs at least ", kFewestPairs, " pairs of images with the whole board, ",
                            work.pairs.size(), " of ", work.given.pairs.size(), " can be used", reasons,
                            "; take more pairs, the board tilted differently in each"));
}

Camera first_camera(const std::vector<Eigen::Matrix3d>& homographies, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  // Without perspective the focal length is open; the check of the tilt refuses such pairs afterwards.
  camera.fx = camera.fy = detail::focal_length(homographies, width, height).value_or(1.2 * width);
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

/// Cameras, poses, and the turn and shift between the cameras of the pair nearest to all others. Pairs whose
/// corners are in another order in one image are left out.
void make_first_guess(Work& work) {
  const Views views = usable_views(work);
  check_number(work);
  const std::size_t n = work.pairs.size();
  StereoRig rig;
  rig.left = first_camera(views.left, work.given.left_width, work.given.left_height);
  rig.right = first_camera(views.right, work.given.right_width, work.given.right_height);
  std::vector<BoardPose> left, relative;
  for (std::size_t k = 0; k < n; ++k) {
    left.push_back(detail::pose_from_homography(rig.left, views.left[k]));
    const BoardPose right = detail::pose_from_homography(rig.right, views.right[k]);
    const Eigen::Matrix3d turn = right.rotation * left[k].rotation.transpose();
    relative.push_back({.rotation = turn, .translation = right.translation - turn * left[k].translation});
  }
  const auto angle = [&](std::size_t i, std::size_t k) {
    return so3_log(relative[i].rotation.transpose() * relative[k].rotation).norm();
  };
  std::size_t middle = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < n; ++k) sum += angle(i, k);
    if (sum < least) {
      least = sum;
      middle = i;
    }
  }
  rig.rotation = relative[middle].rotation;
  rig.translation = relative[middle].translation;
  work.start.rig = rig;
  std::vector<const BoardPair*> kept;
  for (std::size_t k = 0; k < n; ++k) {
    if (angle(middle, k) > kOtherOrder) {
      work.result.warnings.push_back(
          concat("pair ", work.pairs[k]->number,
                 " is left out: its corners are counted from another end of the board in one of the images"));
      continue;
    }
    kept.push_back(work.pairs[k]);
    work.start.poses.push_back(left[k]);
  }
  work.pairs = std::move(kept);
  check_number(work);
}

std::vector<Sighting> all_sightings(const Work& work) {
  std::vector<Sighting> sightings;
  for (std::size_t k = 0; k < work.pairs.size(); ++k) {
    const BoardPair& pair = *work.pairs[k];
    for (int i = 0; i < work.given.board.n_corners(); ++i) {
      const int place = static_cast<int>(k);
      if (pair.in_left(i)) sightings.push_back({place, i, false, pair.left.row(i).transpose()});
      if (pair.in_right(i)) sightings.push_back({place, i, true, pair.right.row(i).transpose()});
    }
  }
  return sightings;
}

/// An adjustment, and the sightings it used: those near their projections.
struct Fit {
  Adjustment adjustment;
  std::vector<Sighting> used;
};

std::vector<Sighting> without_outliers(const Work& work, const RigState& state,
                                       const std::vector<Sighting>& sightings) {
  constexpr double kExact = 1e-3;  // pixels: exact corners differ by rounding alone
  std::vector<double> residuals;
  for (const Sighting& sighting : sightings)
    residuals.push_back(detail::residual_of(work.given.board, state, sighting));
  std::vector<double> ordered = residuals;
  const double limit = std::max(kExact, work.options.outliers * median(ordered));
  std::vector<Sighting> used;
  for (std::size_t i = 0; i < sightings.size(); ++i)
    if (residuals[i] <= limit) used.push_back(sightings[i]);
  return used;
}

Fit fitted(const Work& work, const std::vector<Sighting>& sightings, const RigState& start, LensModel lens) {
  Fit fit;
  const Board& board = work.given.board;
  // Plain squares first: far from the minimum Huber's cost is too flat to steer by.
  fit.adjustment = detail::adjust(board, sightings, start, lens, std::numeric_limits<double>::infinity());
  fit.adjustment = detail::adjust(board, sightings, fit.adjustment.state, lens, work.options.huber);
  fit.used = without_outliers(work, fit.adjustment.state, sightings);
  fit.adjustment = detail::adjust(board, fit.used, fit.adjustment.state, lens, work.options.huber);
  return fit;
}

double rms_of(const Work& work, const Fit& fit, std::optional<bool> right = {}) {
  double squares = 0;
  int n = 0;
  for (const Sighting& sighting : fit.used) {
    if (right && *right != sighting.right) continue;
    const double distance = detail::residual_of(work.given.board, fit.adjustment.state, sighting);
    squares += distance * distance;
    ++n;
  }
  return n > 0 ? std::sqrt(squares / n) : 0;
}

/// Epipolar distances of the corners of a pair that both cameras saw.
std::vector<double> epipolar_distances(const StereoRig& rig, const BoardPair& pair) {
  std::vector<double> distances;
  for (int i = 0; i < static_cast<int>(pair.left.rows()); ++i) {
    if (!pair.in_both(i)) continue;
    const auto distance = epipolar_distance(rig, pair.left.row(i).transpose(), pair.right.row(i).transpose());
    // A pixel that the model has no ray for is as wrong as a pixel can be.
    distances.push_back(distance.value_or(rig.left.width));
  }
  return distances;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Mean epipolar distance in pairs that the rig was not calibrated from: every pair is held back once.
double held_back_error(const Work& work, const Fit& fit, LensModel lens) {
  const int n = static_cast<int>(work.pairs.size()), folds = std::min(n, kMostFolds);
  std::vector<double> distances;
  for (int fold = 0; fold < folds; ++fold) {
    RigState start;
    start.rig = fit.adjustment.state.rig;
    std::vector<int> place(at(n), -1);
    for (int k = 0; k < n; ++k) {
      if (k % folds == fold) continue;
      place[at(k)] = static_cast<int>(start.poses.size());
      start.poses.push_back(fit.adjustment.state.poses[at(k)]);
    }
    std::vector<Sighting> others;
    for (Sighting sighting : fit.used) {
      sighting.pair = place[at(sighting.pair)];
      if (sighting.pair >= 0) others.push_back(sighting);
    }
    const Adjustment without = detail::adjust(work.given.board, others, start, lens, work.options.huber);
    for (int k = fold; k < n; k += folds) {
      const std::vector<double> of_pair = epipolar_distances(without.state.rig, *work.pairs[at(k)]);
      distances.insert(distances.end(), of_pair.begin(), of_pair.end());
    }
  }
  return mean(distances);
}

/// Tries the models of the lens and gives back the fit of the best.
Fit best_fit(Work& work, const std::vector<Sighting>& sightings, const Progress& progress) {
  constexpr double kWorthwhile = 0.97;
  RigFigures& figures = work.result.calibrated.figures;
  figures.lens = work.options.lens.value_or(LensModel::Usual);
  progress.report("calibrate", 0.0);
  Fit best = fitted(work, sightings, work.start, figures.lens);
  if (work.options.lens) return best;
  figures.held_back = held_back_error(work, best, figures.lens);
  work.result.trials.push_back({figures.lens, figures.held_back, rms_of(work, best)});
  double done = 0.3;
  for (const LensModel lens : {LensModel::Radial, LensModel::Full}) {
    progress.report("calibrate", done);
    done += 0.3;
    Fit other = fitted(work, sightings, best.adjustment.state, lens);
    const double error = held_back_error(work, other, lens);
    work.result.trials.push_back({lens, error, rms_of(work, other)});
    if (error >= kWorthwhile * figures.held_back) continue;
    figures.lens = lens;
    figures.held_back = error;
    best = std::move(other);
  }
  return best;
}

double largest_tilt(const std::vector<BoardPose>& poses) {
  double largest = 0;
  for (const BoardPose& a : poses)
    for (const BoardPose& b : poses)
      largest = std::max(largest, std::acos(std::clamp(a.rotation.col(2).dot(b.rotation.col(2)), -1.0, 1.0)));
  return largest;
}

void check_coverage(Work& work) {
  const auto of_side = [&](bool right, int width, int height) {
    std::vector<const BoardCorners*> views;
    for (const BoardPair* pair : work.pairs) views.push_back(right ? &pair->right : &pair->left);
    const double share = detail::coverage(views, width, height);
    if (share < kLeastCoverage)
      throw InvalidInput(concat("the board covers ", std::lround(100 * share), " % of the ",
                                right ? "right" : "left", " image over all pairs, at least ",
                                std::lround(100 * kLeastCoverage),
                                " % are needed; bring it nearer, and into the corners of the image"));
    return share;
  };
  RigFigures& figures = work.result.calibrated.figures;
  figures.left_coverage = of_side(false, work.given.left_width, work.given.left_height);
  figures.right_coverage = of_side(true, work.given.right_width, work.given.right_height);
}

Camera camera_deviations(const Eigen::VectorXd& deviations, int first) {
  Camera camera;
  double* const numbers[] = {&camera.fx, &camera.fy, &camera.cx, &camera.cy, &camera.k1,
                             &camera.k2, &camera.k3, &camera.p1, &camera.p2};
  for (double* number : numbers) *number = deviations[first++];
  return camera;
}

void fill_figures(Work& work, const Fit& fit, const std::vector<Sighting>& sightings) {
  const RigState& state = fit.adjustment.state;
  RigFigures& figures = work.result.calibrated.figures;
  figures.board = work.given.board;
  figures.pairs = static_cast<int>(work.pairs.size());
  figures.corners = static_cast<int>(fit.used.size());
  figures.left_out = static_cast<int>(sightings.size() - fit.used.size());
  figures.left_rms = rms_of(work, fit, false);
  figures.right_rms = rms_of(work, fit, true);
  figures.rms = rms_of(work, fit);
  work.result.covariance =
      detail::covariance(work.given.board, fit.used, state, figures.lens, work.options.huber);
  const Eigen::VectorXd deviations = work.result.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  figures.deviations.left = camera_deviations(deviations, 0);
  figures.deviations.right = camera_deviations(deviations, 9);
  figures.deviations.rotation = deviations.segment<3>(18);
  figures.deviations.translation = deviations.tail<3>();

  std::vector<double> all;
  for (std::size_t k = 0; k < work.pairs.size(); ++k) {
    PairFigures pair;
    pair.number = work.pairs[k]->number;
    pair.rotation = state.poses[k].rotation;
    pair.translation = state.poses[k].translation;
    const std::vector<double> distances = epipolar_distances(state.rig, *work.pairs[k]);
    pair.epipolar = mean(distances);
    all.insert(all.end(), distances.begin(), distances.end());
    double squares = 0;
    int n = 0, used = 0;
    for (const Sighting& sighting : sightings) {
      if (at(sighting.pair) != k) continue;
      const double distance = detail::residual_of(work.given.board, state, sighting);
      squares += distance * distance;
      ++n;
    }
    for (const Sighting& sighting : fit.used) used += at(sighting.pair) == k ? 1 : 0;
    pair.rms = std::sqrt(squares / n);
    pair.left_out = n - used;
    work.result.pairs.push_back(pair);
  }
  figures.epipolar = mean(all);
  for (double& distance : all) distance *= distance;
  figures.epipolar_rms = std::sqrt(mean(all));
}

}  // namespace

std::optional<std::string> RigCalibrationOptions::problem() const {
  if (!(huber >= 0.01)) return concat("huber must be at least 0.01 pixels, got ", huber);
  if (!(outliers >= 2)) return concat("outliers must be at least 2, got ", outliers);
  return {};
}

RigCalibration calibrate_rig(const BoardPairs& pairs, const RigCalibrationOptions& options,
                             const Progress& progress) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  if (const auto found = problem(pairs)) throw InvalidInput(*found);
  Work work{pairs, options, {}, {}, {}};
  make_first_guess(work);
  check_coverage(work);
  const std::vector<Sighting> sightings = all_sightings(work);
  const Fit fit = best_fit(work, sightings, progress);
  RigFigures& figures = work.result.calibrated.figures;
  figures.tilt = largest_tilt(fit.adjustment.state.poses);
  if (figures.tilt < kLeastTilt)
    throw InvalidInput(concat(
        "the board was never tilted: its places differ by ", degrees(figures.tilt), " degrees, at least ",
        degrees(kLeastTilt),
        " are needed to tell the focal length from the distance; tilt it by 20 to 40 degrees, each time to "
        "another side"));
  work.result.calibrated.rig = fit.adjustment.state.rig;
  work.result.iterations = fit.adjustment.iterations;
  if (const std::string found = problem(work.result.calibrated.rig); !found.empty())
    throw InvalidInput(concat("the corners do not fit any rig (", found,
                              "); check that left and right images belong together"));
  fill_figures(work, fit, sightings);
  return work.result;
}

}  // namespace batten
