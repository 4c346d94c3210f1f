#pragma once
#include "camera/rigs.hpp"

#include <algorithm>
#include <limits>

#include "batten/camera/board.hpp"
#include "batten/core/index.hpp"
#include "batten/core/random.hpp"

namespace batten::test {

/// How boards are shown to a rig.
struct BoardScene {
  int pairs = 12;
  double noise = 0;               ///< standard deviation per coordinate, pixels
  double missing = 0;             ///< share of corners that a camera does not see
  double outliers = 0;            ///< share of corners that are off by 5 to 20 pixels
  double tilt = radians(40.0);    ///< largest turn out of the plane of the image
  double near = 0.42, far = 0.6;  ///< distance of the middle of the board, metres
  std::uint64_t seed = 1;
};

/// Corners of a 9x6 board of 30 mm squares at random places where both cameras see all of it.
inline BoardPairs shown_boards(const StereoRig& rig, const BoardScene& scene) {
  BoardPairs result;
  result.board.square = 0.03;
  result.left_width = rig.left.width;
  result.left_height = rig.left.height;
  result.right_width = rig.right.width;
  result.right_height = rig.right.height;
  const int n = result.board.n_corners();
  Random random(scene.seed);
  const Eigen::Vector3d middle(4 * 0.03, 2.5 * 0.03, 0);
  while (static_cast<int>(result.pairs.size()) < scene.pairs) {
    BoardPair pair;
    pair.number = static_cast<int>(result.pairs.size()) + 1;
    pair.left.resize(n, 2);
    pair.right.resize(n, 2);
    const double about = random.uniform(-kPi, kPi), tilt = random.uniform(-scene.tilt, scene.tilt);
    const Eigen::Matrix3d R = so3_exp(tilt * Eigen::Vector3d(std::cos(about), std::sin(about), 0)) *
                              so3_exp(Eigen::Vector3d(0, 0, random.uniform(-0.5, 0.5)));
    const double z = random.uniform(scene.near, scene.far);
    const double down = random.uniform(-0.45, 0.45),
                 across = random.uniform(-0.5, 0.6);  // one after the other
    const Eigen::Vector3d t(across * z, down * z, z);
    bool is_visible = true;
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d left = R * (result.board.corner(i) - middle) + t;
      pair.left.row(i) = project(rig.left, left).transpose();
      pair.right.row(i) = project(rig.right, rig.rotation * left + rig.translation).transpose();
      for (const BoardCorners* corners : {&pair.left, &pair.right})
        is_visible = is_visible && (*corners)(i, 0) > 2 && (*corners)(i, 0) < 638 && (*corners)(i, 1) > 2 &&
                     (*corners)(i, 1) < 478;
    }
    if (!is_visible) continue;
    for (BoardCorners* corners : {&pair.left, &pair.right})
      for (int i = 0; i < n; ++i) {
        (*corners)(i, 0) += scene.noise * random.normal();
        (*corners)(i, 1) += scene.noise * random.normal();
        const double angle = random.uniform(-kPi, kPi), reach = random.uniform(5, 20);
        if (random.uniform() < scene.outliers) {
          const Eigen::RowVector2d off(std::cos(angle), std::sin(angle));
          corners->row(i) += reach * off;
          (*corners)(i, 0) = std::clamp((*corners)(i, 0), 0.0, 640.0);
          (*corners)(i, 1) = std::clamp((*corners)(i, 1), 0.0, 480.0);
        }
        if (random.uniform() < scene.missing)
          corners->row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
      }
    result.pairs.push_back(pair);
  }
  return result;
}

/// webcam_rig() without the sixth power of the radius, which is not estimated by default.
inline StereoRig usual_rig() {
  StereoRig rig = webcam_rig();
  rig.left.k3 = rig.right.k3 = 0;
  return rig;
}

/// The sentence that `work` refuses with, or nothing.
template <typename Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

}  // namespace batten::test
