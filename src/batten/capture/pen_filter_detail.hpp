#pragma once
#include <optional>
#include <span>
#include <vector>

#include "batten/capture/pen_pose.hpp"

// Private to the room: the state of a pen that moves, and what measurements make of it.
namespace batten::detail {

/// Tip P and vector D from the tip to the last LED, each with velocity and acceleration, in this order three
/// numbers each; then a turn of the right camera about its centre (radians) and its relative error of focal
/// length, which hardly change. P and D move with white jerk. D has the length of the pen, by a
/// measurement of its own.
constexpr int kStates = 22;
using State = Eigen::Matrix<double, kStates, 1>;
using StateMatrix = Eigen::Matrix<double, kStates, kStates>;

struct Belief {
  State mean = State::Zero();
  StateMatrix covariance = StateMatrix::Zero();
};

struct FilterNoise {
  double jerk = 10;          ///< density of the jerk of tip and direction vector, m/s³/√Hz
  double blob_floor = 0.01;  ///< added to the standard deviation of every blob, pixels
  double length = 5e-5;      ///< of the distance of the ends, metres
};

/// What the innovations of one frame say of the noise.
struct UpdateReport {
  double innovation = 0;         ///< νᵀ S⁻¹ ν of all blobs before the update
  double residual = 0;           ///< rᵀ R⁻¹ r after it
  double expected_residual = 0;  ///< of that, on average
  int n_numbers = 0;             ///< two for every blob
};

PenPose pose_of(const Belief& belief);
/// Covariance of the tip, and of the direction (radians, along tangent_basis()) as PoseEstimate has them.
PenInformation pose_covariance(const Belief& belief, const Pen& pen);
/// The rig as a belief corrects it.
StereoRig corrected(const StereoRig& rig, const State& mean);

/// From a pose at rest within what a hand may do; the rig with the standard deviations given (radians, 1).
Belief belief_at(const PoseEstimate& estimate, const Pen& pen, double rotation_sigma, double focal_sigma);

StateMatrix transition(double seconds);
/// @param transition  of the same time
Belief predicted(const Belief& belief, const StateMatrix& transition, double seconds, double jerk);

/// Image of an LED and its derivative by the state; nothing behind the camera.
struct LedPrediction {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, kStates> jacobian;
};
std::optional<LedPrediction> predict_led(const StereoRig& rig, CameraSide camera, const Pen& pen,
                                         const State& mean, int led);

/// Takes in the blobs of a frame, by an extended Kalman filter that linearises twice, and the length of the
/// pen.
UpdateReport update(const StereoRig& rig, const Pen& pen, std::span<const LedImage> images,
                    const FilterNoise& noise, Belief& belief);

/// One moment of a filter's past.
struct FilterNode {
  Belief predicted, filtered;
  /// What a correction of this node makes of the one before: C = P Fᵀ P⁻¹(predicted) of Rauch, Tung and
  /// Striebel.
  StateMatrix gain_before = StateMatrix::Zero();
};

StateMatrix smoothing_gain(const Belief& filtered, const StateMatrix& transition,
                           const Belief& next_predicted);

/// What `later`, the smoothed state of the next node, makes of a node.
Belief smoothed(const FilterNode& node, const FilterNode& next, const Belief& later);

}  // namespace batten::detail
