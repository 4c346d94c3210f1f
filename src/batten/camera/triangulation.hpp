#pragma once
#include <optional>

#include <Eigen/Core>

#include "batten/camera/rig.hpp"
#include "batten/core/choices.hpp"

namespace batten {

/// How a point is found from its two images. On real rigs they differ by less than 1 % (docs/methods.md);
/// only for strongly converging cameras, or points nearer than the baseline, the choice shows.
enum class Triangulation {
  Midpoint,  ///< middle of the shortest connection of both rays (H 4.7–4.10)
  Depths,    ///< least squares in both depths (H 4.4); an error in right-camera space × depth, which favours
             ///< one side
  Linear,    ///< homogeneous linear system, singular value decomposition (H 4.6)
  Reprojection,  ///< from the midpoint, two Gauss–Newton steps on the distances in both images
};

constexpr auto choices_of(Triangulation) {
  return choices<Triangulation>("triangulation", {{Triangulation::Midpoint, "midpoint"},
                                                  {Triangulation::Depths, "depths"},
                                                  {Triangulation::Linear, "linear"},
                                                  {Triangulation::Reprojection, "reprojection"}});
}

/// A point of space from its two images.
struct TriangulatedPoint {
  Eigen::Vector3d position;  ///< left camera coordinates, metres
  /// Covariance of the position for blobs with a standard deviation of 1 pixel in every coordinate, m²; times
  /// σ². Along the depth σ_z ≈ z² σ √2 / (f b).
  Eigen::Matrix3d covariance;
  double reprojection = 0;  ///< largest distance between a given and a reprojected pixel
};

/// Triangulates two pixels.
/// Nothing where there is no such point: a pixel belongs to no ray (undistort()), the rays are parallel to
/// less than 1e-9 radians, or they meet behind a camera.
std::optional<TriangulatedPoint> triangulate(const StereoRig& rig, const Eigen::Vector2d& left_pixel,
                                             const Eigen::Vector2d& right_pixel,
                                             Triangulation method = Triangulation::Midpoint);

}  // namespace batten
