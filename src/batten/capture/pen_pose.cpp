#include "batten/capture/pen_pose.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace batten {

namespace {

constexpr int kPoseSteps = 12;
constexpr double kPoseConverged = 1e-3;  // of a standard deviation

using Step = Eigen::Matrix<double, 5, 1>;

struct NormalEquations {
  PenInformation information = PenInformation::Zero();
  Step gradient = Step::Zero();
  double misfit = 0;
  bool in_front = true;
};

NormalEquations assemble(const StereoRig& rig, const Pen& pen, const PenPose& pose,
                         std::span<const LedImage> images) {
  NormalEquations normal;
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(pose.direction);
  for (const LedImage& image : images) {
    Eigen::Matrix<double, 2, 3> by_point;
    const auto pixel = image_in(rig, image.camera, led_position(pen, pose, image.led), &by_point);
    if (!pixel) {
      normal.in_front = false;
      continue;
    }
    Eigen::Matrix<double, 2, 5> J;
    J << by_point, pen.led_distance(image.led) * by_point * basis;
    const Eigen::Matrix2d weight = image.blob.covariance.inverse();
    const Eigen::Vector2d residual = image.blob.pixel - *pixel;
    normal.information += J.transpose() * weight * J;
    normal.gradient += J.transpose() * weight * residual;
    normal.misfit += residual.dot(weight * residual);
  }
  return normal;
}

PenPose moved(const PenPose& pose, const Step& step) {
  PenPose result;
  result.tip = pose.tip + step.head<3>();
  result.direction = (pose.direction + tangent_basis(pose.direction) * step.tail<2>()).normalized();
  return result;
}

}  // namespace

PenInformation pose_information(const StereoRig& rig, const Pen& pen, const PenPose& pose,
                                std::span<const LedImage> images) {
  return assemble(rig, pen, pose, images).information;
}

double pose_misfit(const StereoRig& rig, const Pen& pen, const PenPose& pose,
                   std::span<const LedImage> images) {
  double misfit = 0;
  for (const LedImage& image : images) {
    const auto pixel = image_in(rig, image.camera, led_position(pen, pose, image.led));
    if (!pixel) return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d residual = image.blob.pixel - *pixel;
    misfit += residual.dot(image.blob.covariance.inverse() * residual);
  }
  return misfit;
}

std::optional<PoseEstimate> fit_pose(const StereoRig& rig, const Pen& pen, std::span<const LedImage> images,
                                     const PenPose& start) {
  if (2 * images.size() < 5) return {};
  PenPose pose = start;
  NormalEquations normal = assemble(rig, pen, pose, images);
  if (!normal.in_front) return {};
  double damping = 0;
  for (int step = 0; step < kPoseSteps; ++step) {
    PenInformation damped = normal.information;
    damped.diagonal() *= 1 + damping;
    const Eigen::LDLT<PenInformation> factor(damped);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return {};
    const Step change = factor.solve(normal.gradient);
    if (!change.allFinite()) return {};
    const PenPose next = moved(pose, change);
    const NormalEquations tried = assemble(rig, pen, next, images);
    if (!tried.in_front || tried.misfit > normal.misfit * (1 + 1e-9)) {
      damping = damping > 0 ? 8 * damping : 1e-3;
      continue;
    }
    const double gain = change.dot(normal.gradient);
    pose = next;
    normal = tried;
    damping = damping > 1e-6 ? damping / 8 : 0;
    if (gain < kPoseConverged * kPoseConverged && damping == 0) break;
  }
  const Eigen::SelfAdjointEigenSolver<PenInformation> eigen(normal.information, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] > 1e-9 * eigen.eigenvalues()[4])) return {};
  PoseEstimate estimate;
  estimate.pose = pose;
  estimate.covariance = normal.information.inverse();
  estimate.chi_square = normal.misfit;
  estimate.n_blobs = static_cast<int>(images.size());
  return estimate;
}

PenPose pose_of_points(const Pen& pen, std::span<const int> leds, std::span<const Eigen::Vector3d> points) {
  const double n = static_cast<double>(leds.size());
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double along = 0;  // C of H (4.12)
  for (std::size_t i = 0; i < leds.size(); ++i) {
    centroid += points[i] / n;
    along += pen.led_distance(leds[i]) / n;
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sense = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < leds.size(); ++i) {
    const Eigen::Vector3d off = points[i] - centroid;
    scatter += off * off.transpose();
    sense += (pen.led_distance(leds[i]) - along) * off;
  }
  PenPose pose;
  pose.direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(2);
  if (pose.direction.dot(sense) < 0) pose.direction = -pose.direction;
  pose.tip = centroid - along * pose.direction;
  return pose;
}

}  // namespace batten
