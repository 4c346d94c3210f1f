#pragma once
#include <optional>
#include <string>

#include <Eigen/Core>

namespace batten {

/// A pinhole camera with radial and tangential lens distortion [brown1971]. Camera axes: x right, y down, z
/// forward. Pixels count from the outer corner of the first one: its centre is (0.5, 0.5). Programs that give
/// that centre the coordinates (0, 0), OpenCV among them, exchange corners and principal points with a shift
/// of 0.5.
struct Camera {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  double fx = 0;   ///< focal lengths, pixels
  double fy = 0;
  double cx = 0;  ///< principal point, pixels
  double cy = 0;
  double k1 = 0;  ///< radial distortion, of r²
  double k2 = 0;  ///< of r⁴
  double k3 = 0;  ///< of r⁶
  double p1 = 0;  ///< tangential distortion
  double p2 = 0;
};

/// What is wrong with the numbers of a camera, with field, value and range; empty when nothing is.
std::string problem(const Camera& camera);

/// Distortion of normalised coordinates (x, y) = (X/Z, Y/Z), r² = x² + y²:
/// x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²), y' = y (…) + p1 (r² + 2 y²) + 2 p2 x y.
/// @param jacobian  where not null: ∂(x', y')/∂(x, y)
Eigen::Vector2d distort(const Camera& camera, const Eigen::Vector2d& normalised,
                        Eigen::Matrix2d* jacobian = nullptr);

/// Pixel of a distorted normalised point: (fx x' + cx, fy y' + cy), and back.
Eigen::Vector2d to_pixel(const Camera& camera, const Eigen::Vector2d& distorted);
Eigen::Vector2d from_pixel(const Camera& camera, const Eigen::Vector2d& pixel);

/// Pixel of a point in camera coordinates. @pre the point lies in front of the camera: z > 0.
/// @param jacobian  where not null: ∂(u, v)/∂(x, y, z)
Eigen::Vector2d project(const Camera& camera, const Eigen::Vector3d& point,
                        Eigen::Matrix<double, 2, 3>* jacobian = nullptr);

/// Normalised coordinates of a pixel, by Newton's method on distort(); fixed-point iteration fails far off
/// the axis. Nothing where the lens model turns back on itself (the derivative of the distorted radius
/// vanishes between the axis and the point): the pixel belongs to no ray then. Exact to 1e-12 of the
/// normalised plane.
std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace batten
