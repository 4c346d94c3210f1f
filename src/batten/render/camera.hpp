#pragma once
#include <string_view>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// From where a picture is taken.
struct View {
  double azimuth_deg = -55;   ///< of the viewer, from the x axis towards the y axis
  double elevation_deg = 28;  ///< of the viewer above the horizon, −90 … 90
  bool perspective = true;    ///< false: parallel projection
  int up_axis = 2;            ///< 0 x, 1 y, 2 z; azimuth counts from the axis after it
  double zoom = 1;            ///< enlarges about the middle of the picture, above 0
};

/// `front` (from −y), `back`, `left`, `right`, `top`, `bottom`, `three-quarter`, or `azimuth,elevation` in
/// degrees. @throws InvalidInput naming these forms.
View parse_view(std::string_view text);

/// A camera that shows all of a set of points. Its coordinates: x right, y up, z towards the viewer, origin
/// in the middle of the model. Pixels: x right, y down, origin in the upper left corner.
class PictureCamera {
 public:
  /// @param left, top, width, height of the part of the picture that the points fill, in pixels.
  /// @throws InvalidInput when no point is finite.
  PictureCamera(const Points& points, const View& view, double left, double top, double width, double height);

  Eigen::Vector3d to_camera(const Eigen::Vector3d& world) const { return rotation_ * (world - target_); }
  /// Rotation from world to camera.
  const Eigen::Matrix3d& rotation() const { return rotation_; }
  /// Pixel of a point in camera coordinates, and a depth that is linear over straight things in the picture,
  /// larger nearer, 0 … 1 over the model.
  Eigen::Vector3d project(const Eigen::Vector3d& camera) const;
  /// Unit vector from a point towards the viewer, camera coordinates.
  Eigen::Vector3d towards_viewer(const Eigen::Vector3d& camera) const;
  /// Ray through a pixel: a point at z = 0 and the direction away from the viewer (camera coordinates).
  void ray(double pixel_x, double pixel_y, Eigen::Vector3d& origin, Eigen::Vector3d& direction) const;
  /// Length of a pixel at a point, in world units.
  double pixel_size(const Eigen::Vector3d& camera) const;

 private:
  double raw_depth(double z) const { return perspective_ ? 1 / (distance_ - z) : z; }

  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();
  bool perspective_ = true;
  double distance_ = 1;  ///< of the viewer from the origin
  double scale_ = 1;     ///< pixels per unit: at the origin divided by distance where perspective
  double centre_x_ = 0, centre_y_ = 0;
  double far_ = 0, depth_range_ = 1;
};

}  // namespace batten
