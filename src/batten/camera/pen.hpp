#pragma once
#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/camera/rig.hpp"

namespace batten {

/// Number of light-emitting diodes on a pen.
constexpr int kPenLeds = 4;

/// A pen with light-emitting diodes on the line of its axis (H 4.1.2). All six distances between two of them
/// differ, so that distances tell which are seen.
struct Pen {
  /// T: from the tip to the LED next to it, metres, at least 0.
  double tip_offset = 0.06;
  /// From that LED to each of them, metres: 0 first, then increasing (H 4.11).
  std::array<double, kPenLeds> leds = {0, 0.07, 0.11, 0.16};

  /// From the tip to an LED, metres.
  double led_distance(int led) const { return tip_offset + leds[static_cast<std::size_t>(led)]; }
};

/// What is wrong with the numbers of a pen, with field and value; empty when nothing is.
std::string problem(const Pen& pen);

/// Where a pen is, in left camera coordinates. A turn about its axis cannot be seen.
struct PenPose {
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();          ///< metres
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitY();  ///< unit vector from the tip to the other end
};

/// Place of an LED in left camera coordinates, metres. @param led from the tip, from 0.
Eigen::Vector3d led_position(const Pen& pen, const PenPose& pose, int led);

/// Two unit vectors at right angles to a unit vector and to each other, as columns.
Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& direction);

enum class CameraSide { Left, Right };

/// Image of a point of the rig (left camera coordinates) in one of its cameras, pixels; nothing where it lies
/// behind the camera.
/// @param jacobian  where not null: ∂(u, v)/∂(x, y, z)
std::optional<Eigen::Vector2d> image_in(const StereoRig& rig, CameraSide side, const Eigen::Vector3d& point,
                                        Eigen::Matrix<double, 2, 3>* jacobian = nullptr);

/// Whether a pixel lies in the image of a camera.
bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace batten
