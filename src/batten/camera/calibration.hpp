#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/board.hpp"
#include "batten/camera/rig.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Which coefficients of the lens are estimated; the others are zero. More fit the given corners better and
/// may fit others worse.
enum class LensModel {
  Radial,  ///< k1, k2: few pairs, or lenses of good make
  Usual,   ///< k1, k2, p1, p2
  Full,    ///< k1, k2, k3, p1, p2: wide lenses seen up to their corners
};

constexpr auto choices_of(LensModel) {
  return choices<LensModel>(
      "lens model", {{LensModel::Radial, "radial"}, {LensModel::Usual, "usual"}, {LensModel::Full, "full"}});
}

/// Options of calibrate_rig().
struct RigCalibrationOptions {
  /// Nothing: the model with the smallest epipolar error on pairs held back one after the other. `Usual`
  /// stays unless another is better by 1 %. Costs three calibrations per pair (at most 12 parts of the
  /// pairs).
  std::optional<LensModel> lens = std::nullopt;
  /// Distance in pixels from which on the weight of a corner falls (Huber); at least 0.01.
  double huber = 1.0;
  /// After a first fit corners beyond this multiple of the median residual are left out; at least 2.
  double outliers = 4.0;
  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Standard deviations of all numbers of a rig, in their own units; 0 for what was not estimated.
struct RigDeviations {
  Camera left, right;  ///< fx, fy, cx, cy in pixels; distortion; the sizes are 0
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< radians, about the axes of the right camera
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< metres
};

/// How well a calibration fits, kept with the rig: later figures are held against them.
struct RigFigures {
  Board board;
  LensModel lens = LensModel::Usual;
  int pairs = 0;                                ///< used
  int corners = 0;                              ///< used, over both images
  int left_out = 0;                             ///< corners left out as outliers
  double left_rms = 0, right_rms = 0, rms = 0;  ///< distances of used corners to their projections, pixels
  double epipolar = 0;      ///< mean epipolar_distance() over all corners of the pairs, pixels
  double epipolar_rms = 0;  ///< pixels
  double held_back = 0;     ///< mean epipolar distance in pairs held back; 0 where none were
  double left_coverage = 0, right_coverage = 0;  ///< share of the image that was under the board, 0 to 1
  double tilt = 0;                               ///< largest angle between two places of the board, radians
  RigDeviations deviations;
};

/// A rig and how well it is known.
struct CalibratedRig {
  StereoRig rig;
  RigFigures figures;
};

/// Held-back epipolar error of one model of the lens.
struct LensTrial {
  LensModel lens = LensModel::Usual;
  double held_back = 0;  ///< pixels
  double rms = 0;        ///< reprojection on all pairs, pixels
};

/// Fit of one pair.
struct PairFigures {
  int number = 0;
  double rms = 0;                                          ///< pixels, over all corners, outliers included
  double epipolar = 0;                                     ///< mean, pixels
  int left_out = 0;                                        ///< corners
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< board to left camera: X = rotation · board + …
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< metres
};

/// Number of entries of RigCalibration::covariance per side.
constexpr int kRigParameters = 24;

/// Result of calibrate_rig().
struct RigCalibration {
  CalibratedRig calibrated;
  std::vector<PairFigures> pairs;  ///< of the pairs used, in their order
  std::vector<LensTrial> trials;   ///< empty where the model was given
  /// Covariance (24 × 24) of fx, fy, cx, cy, k1, k2, k3, p1, p2 of the left camera, the same of the right
  /// one, rotation vector (applied from the left) and translation; zero for what was not estimated.
  Eigen::MatrixXd covariance;
  std::vector<std::string> warnings;  ///< pairs that were left out, and why
  int iterations = 0;                 ///< of the last adjustment
};

/// Calibrates a stereo rig from places of a board.
///
/// Homographies by the normalised linear method [hartley2004] give focal lengths in closed form and poses
/// [zhang2000]; then one adjustment of both cameras, rotation, translation and all poses minimises the
/// distances between corners and projections (Levenberg–Marquardt, Huber), and a second one does without
/// outliers. The standard deviations are those of the inverse normal matrix times the variance of the
/// residuals.
///
/// Pairs with fewer than 12 corners seen by both cameras, or whose corners are in another order in one image
/// than in the other, are left out with a warning. Cost: O(corners) per step; the poses are eliminated.
/// @throws InvalidInput as problem() of options and pairs; when fewer than 4 pairs are usable, the board
/// covers less than 30 % of either image, or was never tilted by 10 degrees; each with the remedy. Cancelled.
RigCalibration calibrate_rig(const BoardPairs& pairs, const RigCalibrationOptions& options = {},
                             const Progress& progress = {});

/// How well a rig describes corners that it need not have been calibrated from.
struct RigCheck {
  int pairs = 0;
  int corners = 0;            ///< seen by both cameras and triangulated
  int lost = 0;               ///< seen by both, but their pixels belong to no rays that meet
  double epipolar = 0;        ///< mean epipolar_distance(), pixels
  double epipolar_rms = 0;    ///< pixels
  double neighbour_mean = 0;  ///< distance of triangulated corners next to each other, squares
  double neighbour_std = 0;   ///< its standard deviation, squares
  double rigid_rms = 0;       ///< distance of triangulated corners to the board laid upon them, squares
  std::vector<PairFigures>
      each;  ///< number, epipolar, and `rms` in squares to the board laid upon the corners
};

/// Triangulates (midpoint) and measures the corners of pairs. @throws InvalidInput as problem() of both, and
/// when no corner was seen by both cameras.
RigCheck check_rig(const StereoRig& rig, const BoardPairs& pairs);

}  // namespace batten
