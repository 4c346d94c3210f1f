#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/board.hpp"
#include "batten/camera/rig_adjustment_detail.hpp"

// First guesses of a calibration; not part of the library's interface.
namespace batten::detail {

/// The homography (3 × 3, up to scale, positive at the centre of the corners) from board coordinates (x, y)
/// in metres to pixels, by the normalised linear method [hartley2004]. Nothing where the corners seen are
/// fewer than 4 or nearly on one line.
std::optional<Eigen::Matrix3d> homography(const Board& board, const BoardCorners& corners);

/// Focal length in pixels of a camera without distortion whose principal point is the middle of its image,
/// from the constraints of every homography [zhang2000]. Nothing where they show no perspective.
std::optional<double> focal_length(const std::vector<Eigen::Matrix3d>& homographies, int width, int height);

/// Pose of the board in front of a camera, from its homography.
BoardPose pose_from_homography(const Camera& camera, const Eigen::Matrix3d& homography);

/// Share of the image, 0 to 1, that lay under the board in one of the views: between the outermost corners.
double coverage(const std::vector<const BoardCorners*>& views, int width, int height);

}  // namespace batten::detail
