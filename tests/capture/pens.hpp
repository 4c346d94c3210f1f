#pragma once
#include <vector>

#include "batten/capture/pen_pose.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/simulation/pen.hpp"

namespace batten::test {

/// A pose 0.4 to 0.8 m ahead of the cameras, leaning by up to 60 degrees.
inline PenPose random_pose(Random& random) {
  const StereoRig rig = nominal_rig(PenRig::Global);
  PenPose pose;
  pose.direction = Eigen::Vector3d(0, -1, 0) + 1.2 * random.uniform() * random.direction();
  pose.direction.normalize();
  const Eigen::Vector3d ahead = (Eigen::Vector3d::UnitZ() + rig.rotation.transpose().col(2)).normalized();
  pose.tip = rig.right_centre() / 2 + random.uniform(0.4, 0.8) * ahead + 0.03 * random.normal3() -
             0.14 * pose.direction;
  return pose;
}

/// Blobs of the LEDs of a pose in one camera, with normal errors; those that are not wanted left out.
inline std::vector<Blob> blobs_of(const StereoRig& rig, CameraSide side, const Pen& pen, const PenPose& pose,
                                  double sigma, Random& random, const std::vector<int>& leds = {0, 1, 2, 3}) {
  std::vector<Blob> blobs;
  for (const int led : leds) {
    const auto pixel = image_in(rig, side, led_position(pen, pose, led));
    if (!pixel) continue;
    const double down = random.normal(), across = random.normal();  // one after the other
    const Eigen::Vector2d off(across, down);
    blobs.push_back({*pixel + sigma * off, sigma * sigma * Eigen::Matrix2d::Identity()});
  }
  return blobs;
}

inline std::vector<LedImage> images_of(const StereoRig& rig, const Pen& pen, const PenPose& pose,
                                       double sigma, Random& random) {
  std::vector<LedImage> images;
  for (const CameraSide side : {CameraSide::Left, CameraSide::Right}) {
    const std::vector<Blob> blobs = blobs_of(rig, side, pen, pose, sigma, random);
    for (std::size_t i = 0; i < blobs.size(); ++i) images.push_back({side, static_cast<int>(i), blobs[i]});
  }
  return images;
}

}  // namespace batten::test
