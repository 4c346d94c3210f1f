#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/camera/board.hpp"
#include "batten/camera/calibration.hpp"
#include "batten/camera/rig.hpp"

// Joint adjustment of a rig; not part of the library's interface.
namespace batten::detail {

/// Board to left camera: X = rotation · board + translation.
struct BoardPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// A corner in one image.
struct Sighting {
  int pair = 0;  ///< place in the list of poses
  int corner = 0;
  bool right = false;
  Eigen::Vector2d pixel;
};

struct RigState {
  StereoRig rig;
  std::vector<BoardPose> poses;
};

struct Adjustment {
  RigState state;
  double cost = 0;  ///< Σ ρ(|residual|), squared pixels
  int iterations = 0;
  bool converged = false;
};

/// Distance of a sighting to its projection, pixels; infinite behind the camera.
double residual_of(const Board& board, const RigState& state, const Sighting& sighting);

/// Minimises the Huber cost over cameras, R, T and poses. @param huber pixels; infinity for plain squares.
Adjustment adjust(const Board& board, const std::vector<Sighting>& sightings, const RigState& start,
                  LensModel lens, double huber);

/// Covariance of the 24 numbers of the rig: inverse of the normal matrix after the poses are eliminated,
/// times the weighted variance of the residuals.
Eigen::MatrixXd covariance(const Board& board, const std::vector<Sighting>& sightings, const RigState& state,
                           LensModel lens, double huber);

}  // namespace batten::detail
