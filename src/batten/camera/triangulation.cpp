#include "batten/camera/triangulation.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace batten {

namespace {

constexpr double kParallel = 1e-9;  // radians between rays that count as parallel
constexpr int kReprojectionSteps = 2;

/// Both images of a point, differentiated by the point in left coordinates.
struct Images {
  Eigen::Vector4d pixels;
  Eigen::Matrix<double, 4, 3> jacobian;
};

Images images_of(const StereoRig& rig, const Eigen::Vector3d& point) {
  Images images;
  Eigen::Matrix<double, 2, 3> jacobian;
  images.pixels.head<2>() = project(rig.left, point, &jacobian);
  images.jacobian.topRows<2>() = jacobian;
  images.pixels.tail<2>() = project(rig.right, rig.rotation * point + rig.translation, &jacobian);
  images.jacobian.bottomRows<2>() = jacobian * rig.rotation;
  return images;
}

/// Rays of both cameras in left coordinates: the left one from the origin, the right one from `centre`.
Eigen::Vector3d midpoint(const Eigen::Vector3d& left, const Eigen::Vector3d& right,
                         const Eigen::Vector3d& centre) {
  const double across = left.dot(right);
  const double determinant = left.squaredNorm() * right.squaredNorm() - across * across;
  const double s = (right.squaredNorm() * left.dot(centre) - across * right.dot(centre)) / determinant;
  const double t = (across * left.dot(centre) - left.squaredNorm() * right.dot(centre)) / determinant;
  return (s * left + centre + t * right) / 2;
}

/// Depths z_l, z_r with z_r x_r = R z_l x_l + T in the least squares sense (H 4.4), and z_l x_l.
Eigen::Vector3d by_depths(const StereoRig& rig, const Eigen::Vector3d& left, const Eigen::Vector3d& right) {
  Eigen::Matrix<double, 3, 2> A;
  A << rig.rotation * left, -right;
  const Eigen::Vector2d depths = (A.transpose() * A).ldlt().solve(-A.transpose() * rig.translation);
  return depths[0] * left;
}

/// x × (P X) = 0 for both cameras (H 4.6): the right singular vector of the smallest singular value.
Eigen::Vector3d by_linear_system(const StereoRig& rig, const Eigen::Vector3d& left,
                                 const Eigen::Vector3d& right) {
  Eigen::Matrix<double, 3, 4> P;
  P << rig.rotation, rig.translation;
  Eigen::Matrix4d A;
  A << -1, 0, left.x(), 0, 0, -1, left.y(), 0, Eigen::RowVector4d::Zero(), Eigen::RowVector4d::Zero();
  A.row(2) = right.x() * P.row(2) - P.row(0);
  A.row(3) = right.y() * P.row(2) - P.row(1);
  const Eigen::Vector4d X = Eigen::JacobiSVD<Eigen::Matrix4d>(A, Eigen::ComputeFullV).matrixV().col(3);
  return X.head<3>() / X[3];
}

}  // namespace

std::optional<TriangulatedPoint> triangulate(const StereoRig& rig, const Eigen::Vector2d& left_pixel,
                                             const Eigen::Vector2d& right_pixel, Triangulation method) {
  const std::optional<Eigen::Vector2d> left = undistort(rig.left, left_pixel);
  const std::optional<Eigen::Vector2d> right = undistort(rig.right, right_pixel);
  if (!left || !right) return {};
  const Eigen::Vector3d left_ray = left->homogeneous();
  const Eigen::Vector3d right_ray = rig.rotation.transpose() * right->homogeneous();
  if (left_ray.cross(right_ray).norm() < kParallel * left_ray.norm() * right_ray.norm()) return {};

  const auto in_front = [&](const Eigen::Vector3d& point) {
    return point.allFinite() && point.z() > 0 && (rig.rotation * point + rig.translation).z() > 0;
  };
  Eigen::Vector4d given;
  given << left_pixel, right_pixel;
  TriangulatedPoint result;
  switch (method) {
    case Triangulation::Depths:
      result.position = by_depths(rig, left_ray, right->homogeneous());
      break;
    case Triangulation::Linear:
      result.position = by_linear_system(rig, left_ray, right->homogeneous());
      break;
    case Triangulation::Midpoint:
    case Triangulation::Reprojection:
      result.position = midpoint(left_ray, right_ray, rig.right_centre());
      break;
  }
  if (!in_front(result.position)) return {};
  if (method == Triangulation::Reprojection) {
    for (int step = 0; step < kReprojectionSteps; ++step) {
      const Images images = images_of(rig, result.position);
      const Eigen::Vector3d change = (images.jacobian.transpose() * images.jacobian)
                                         .ldlt()
                                         .solve(images.jacobian.transpose() * (given - images.pixels));
      if (!in_front(result.position + change)) return {};
      result.position += change;
    }
  }
  const Images images = images_of(rig, result.position);
  result.covariance = (images.jacobian.transpose() * images.jacobian).inverse();
  const Eigen::Vector4d residual = images.pixels - given;
  result.reprojection = std::max(residual.head<2>().norm(), residual.tail<2>().norm());
  return result;
}

}  // namespace batten
