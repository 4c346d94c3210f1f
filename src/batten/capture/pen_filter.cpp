#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/capture/pen_filter_detail.hpp"
#include "batten/rotation/so3.hpp"

// [bar2001] for the model of white jerk, [rauch1965] for smoothing.
namespace batten::detail {

namespace {

constexpr int kTip = 0, kVector = 9, kTurn = 18, kFocal = 21;
constexpr double kVelocity = 0.3;         // m/s, standard deviation of a pen whose speed is not known
constexpr double kAcceleration = 3.0;     // m/s²
constexpr double kRigDrift = 1e-7;        // per √s: the rig of tomorrow is nearly that of today
constexpr double kLeastVariance = 1e-16;  // of a rig that is exact: covariances must stay regular
constexpr int kLinearisations = 2;

using Rows = Eigen::Matrix<double, Eigen::Dynamic, kStates, Eigen::RowMajor, 2 * kPenLeds + 1, kStates>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * kPenLeds + 1, 1>;
using RigSquare =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kPenLeds + 1, 2 * kPenLeds + 1>;

/// Measurements stacked: two rows for every blob and, last, the length of the pen.
struct Stacked {
  Rows jacobian;
  Column given, predicted;
  RigSquare noise;
  bool valid = true;
};

Stacked stack(const StereoRig& rig, const Pen& pen, const State& mean, std::span<const LedImage> images,
              const FilterNoise& noise, bool with_length) {
  const auto n = static_cast<Eigen::Index>(2 * images.size()) + (with_length ? 1 : 0);
  Stacked all{Rows::Zero(n, kStates), Column::Zero(n), Column::Zero(n), RigSquare::Zero(n, n)};
  Eigen::Index row = 0;
  for (const LedImage& image : images) {
    const auto led = predict_led(rig, image.camera, pen, mean, image.led);
    if (!led) {
      all.valid = false;
      return all;
    }
    all.jacobian.middleRows<2>(row) = led->jacobian;
    all.given.segment<2>(row) = image.blob.pixel;
    all.predicted.segment<2>(row) = led->pixel;
    all.noise.block<2, 2>(row, row) =
        image.blob.covariance + noise.blob_floor * noise.blob_floor * Eigen::Matrix2d::Identity();
    row += 2;
  }
  if (with_length) {
    const Eigen::Vector3d D = mean.segment<3>(kVector);
    all.jacobian.block<1, 3>(row, kVector) = D.normalized().transpose();
    all.given[row] = pen.led_distance(kPenLeds - 1);
    all.predicted[row] = D.norm();
    all.noise(row, row) = noise.length * noise.length;
  }
  return all;
}

}  // namespace

PenPose pose_of(const Belief& belief) {
  return {belief.mean.segment<3>(kTip), belief.mean.segment<3>(kVector).normalized()};
}

PenInformation pose_covariance(const Belief& belief, const Pen& pen) {
  Eigen::Matrix<double, 5, kStates> to_pose = Eigen::Matrix<double, 5, kStates>::Zero();
  to_pose.block<3, 3>(0, kTip).setIdentity();
  to_pose.block<2, 3>(3, kVector) = tangent_basis(belief.mean.segment<3>(kVector).normalized()).transpose() /
                                    pen.led_distance(kPenLeds - 1);
  return to_pose * belief.covariance * to_pose.transpose();
}

StereoRig corrected(const StereoRig& rig, const State& mean) {
  StereoRig result = rig;
  const Eigen::Matrix3d turn = so3_exp(mean.segment<3>(kTurn));
  result.rotation = turn * rig.rotation;
  result.translation = turn * rig.translation;
  result.right.fx *= 1 + mean[kFocal];
  result.right.fy *= 1 + mean[kFocal];
  return result;
}

Belief belief_at(const PoseEstimate& estimate, const Pen& pen, double rotation_sigma, double focal_sigma) {
  const double length = pen.led_distance(kPenLeds - 1);
  Belief belief;
  belief.mean.segment<3>(kTip) = estimate.pose.tip;
  belief.mean.segment<3>(kVector) = length * estimate.pose.direction;
  Eigen::Matrix<double, 6, 5> from_pose = Eigen::Matrix<double, 6, 5>::Zero();
  from_pose.topLeftCorner<3, 3>().setIdentity();
  from_pose.bottomRightCorner<3, 2>() = length * tangent_basis(estimate.pose.direction);
  // The pose is taken in once more with its first frame: wide enough that it does not count twice.
  Eigen::Matrix<double, 6, 6> spread = 25 * from_pose * estimate.covariance * from_pose.transpose();
  spread.diagonal().array() += 1e-6;
  belief.covariance.block<3, 3>(kTip, kTip) = spread.topLeftCorner<3, 3>();
  belief.covariance.block<3, 3>(kTip, kVector) = spread.topRightCorner<3, 3>();
  belief.covariance.block<3, 3>(kVector, kTip) = spread.bottomLeftCorner<3, 3>();
  belief.covariance.block<3, 3>(kVector, kVector) = spread.bottomRightCorner<3, 3>();
  for (const int block : {kTip, kVector}) {
    belief.covariance.block<3, 3>(block + 3, block + 3).diagonal().setConstant(kVelocity * kVelocity);
    belief.covariance.block<3, 3>(block + 6, block + 6).diagonal().setConstant(kAcceleration * kAcceleration);
  }
  belief.covariance.block<3, 3>(kTurn, kTurn)
      .diagonal()
      .setConstant(std::max(rotation_sigma * rotation_sigma, kLeastVariance));
  belief.covariance(kFocal, kFocal) = std::max(focal_sigma * focal_sigma, kLeastVariance);
  return belief;
}

StateMatrix transition(double seconds) {
  StateMatrix F = StateMatrix::Identity();
  for (const int block : {kTip, kVector}) {
    F.block<3, 3>(block, block + 3).diagonal().setConstant(seconds);
    F.block<3, 3>(block, block + 6).diagonal().setConstant(seconds * seconds / 2);
    F.block<3, 3>(block + 3, block + 6).diagonal().setConstant(seconds);
  }
  return F;
}

Belief predicted(const Belief& belief, const StateMatrix& transition, double seconds, double jerk) {
  Belief next;
  next.mean = transition * belief.mean;
  next.covariance = transition * belief.covariance * transition.transpose();
  const double q = jerk * jerk, t = seconds;
  const double powers[3][3] = {{std::pow(t, 5) / 20, std::pow(t, 4) / 8, t * t * t / 6},
                               {std::pow(t, 4) / 8, t * t * t / 3, t * t / 2},
                               {t * t * t / 6, t * t / 2, t}};
  for (const int block : {kTip, kVector})
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        next.covariance.block<3, 3>(block + 3 * i, block + 3 * j).diagonal().array() += q * powers[i][j];
  next.covariance.bottomRightCorner<4, 4>().diagonal().array() += kRigDrift * kRigDrift * t;
  return next;
}

std::optional<LedPrediction> predict_led(const StereoRig& rig, CameraSide camera, const Pen& pen,
                                         const State& mean, int led) {
  const double share = pen.led_distance(led) / pen.led_distance(kPenLeds - 1);
  const Eigen::Vector3d point = mean.segment<3>(kTip) + share * mean.segment<3>(kVector);
  Eigen::Matrix<double, 2, 3> by_point;
  LedPrediction result;
  result.jacobian.setZero();
  if (camera == CameraSide::Left) {
    const auto pixel = image_in(rig, camera, point, &by_point);
    if (!pixel) return {};
    result.pixel = *pixel;
  } else {
    const StereoRig right = corrected(rig, mean);
    const Eigen::Vector3d turned = right.rotation * point + right.translation;
    if (!(turned.z() > 0)) return {};
    Eigen::Matrix<double, 2, 3> by_turned;
    result.pixel = project(right.right, turned, &by_turned);
    by_point = by_turned * right.rotation;
    // The turn comes after the rig's own, so that its derivative at the present turn is that of a small one.
    result.jacobian.block<2, 3>(0, kTurn) = -by_turned * hat(turned);
    result.jacobian.col(kFocal) =
        (result.pixel - Eigen::Vector2d(right.right.cx, right.right.cy)) / (1 + mean[kFocal]);
  }
  result.jacobian.block<2, 3>(0, kTip) = by_point;
  result.jacobian.block<2, 3>(0, kVector) = share * by_point;
  return result;
}

UpdateReport update(const StereoRig& rig, const Pen& pen, std::span<const LedImage> images,
                    const FilterNoise& noise, Belief& belief) {
  UpdateReport report;
  report.n_numbers = static_cast<int>(2 * images.size());
  const Belief prior = belief;
  for (int pass = 0; pass < kLinearisations; ++pass) {
    const Stacked all = stack(rig, pen, belief.mean, images, noise, true);
    if (!all.valid) {
      belief = prior;
      return report;
    }
    const Eigen::Matrix<double, kStates, Eigen::Dynamic, 0, kStates, 2 * kPenLeds + 1> PHt =
        prior.covariance * all.jacobian.transpose();
    const RigSquare S = all.jacobian * PHt + all.noise;
    const Eigen::LLT<RigSquare> factor(S);
    // Linearised where the estimate is now, applied to where the prediction was.
    const Column off = all.given - all.predicted - all.jacobian * (prior.mean - belief.mean);
    belief.mean = prior.mean + PHt * factor.solve(off);
    belief.covariance = prior.covariance - PHt * factor.solve(PHt.transpose());
    belief.covariance = (0.5 * (belief.covariance + belief.covariance.transpose())).eval();
    if (pass == 0 && report.n_numbers > 0) {
      const Eigen::Index n = report.n_numbers;
      const Column blobs = off.head(n);
      report.innovation = blobs.dot(S.topLeftCorner(n, n).llt().solve(blobs));
    }
  }
  const Stacked all = stack(rig, pen, belief.mean, images, noise, false);
  if (!all.valid || images.empty()) return report;
  const Eigen::LLT<RigSquare> weight(all.noise);
  const Column rest = all.given - all.predicted;
  report.residual = rest.dot(weight.solve(rest));
  const RigSquare taken = all.jacobian * belief.covariance * all.jacobian.transpose();
  report.expected_residual = report.n_numbers - weight.solve(taken).trace();
  return report;
}

StateMatrix smoothing_gain(const Belief& filtered, const StateMatrix& transition,
                           const Belief& next_predicted) {
  // Solved from the left, as covariances are symmetric.
  const Eigen::LLT<StateMatrix> factor(next_predicted.covariance);
  return factor.solve(transition * filtered.covariance).transpose();
}

Belief smoothed(const FilterNode& node, const FilterNode& next, const Belief& later) {
  const StateMatrix& C = next.gain_before;
  Belief result;
  result.mean = node.filtered.mean + C * (later.mean - next.predicted.mean);
  result.covariance =
      node.filtered.covariance + C * (later.covariance - next.predicted.covariance) * C.transpose();
  result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
  return result;
}

}  // namespace batten::detail
