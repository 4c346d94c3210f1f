#include "batten/camera/pen.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"

namespace batten {

std::string problem(const Pen& pen) {
  if (!(pen.tip_offset >= 0) || !std::isfinite(pen.tip_offset))
    return concat("tip_offset is ", pen.tip_offset, "; expected metres, at least 0");
  if (pen.leds[0] != 0) return concat("leds[0] is ", pen.leds[0], "; distances count from the first LED: 0");
  for (std::size_t i = 1; i < pen.leds.size(); ++i)
    if (!(pen.leds[i] > pen.leds[i - 1]) || !std::isfinite(pen.leds[i]))
      return concat("leds[", i, "] is ", pen.leds[i], "; expected more than the ", pen.leds[i - 1],
                    " m of the one before");
  return {};
}

Eigen::Vector3d led_position(const Pen& pen, const PenPose& pose, int led) {
  return pose.tip + pen.led_distance(led) * pose.direction;
}

Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& direction) {
  // The axis that the direction is farthest from keeps the cross product long.
  Eigen::Index axis = 0;
  direction.cwiseAbs().minCoeff(&axis);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = direction.cross(Eigen::Vector3d::Unit(axis)).normalized();
  basis.col(1) = direction.cross(basis.col(0));
  return basis;
}

std::optional<Eigen::Vector2d> image_in(const StereoRig& rig, CameraSide side, const Eigen::Vector3d& point,
                                        Eigen::Matrix<double, 2, 3>* jacobian) {
  if (side == CameraSide::Left) {
    if (!(point.z() > 0)) return {};
    return project(rig.left, point, jacobian);
  }
  const Eigen::Vector3d turned = rig.rotation * point + rig.translation;
  if (!(turned.z() > 0)) return {};
  const Eigen::Vector2d pixel = project(rig.right, turned, jacobian);
  if (jacobian) *jacobian = (*jacobian * rig.rotation).eval();
  return pixel;
}

bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width && pixel.y() <= camera.height;
}

}  // namespace batten
