#include "batten/capture/pen_pose.hpp"

#include "capture/pens.hpp"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace batten::test {
namespace {

// Without noise the pose is the true one, whatever the start.
TEST(FitPose, FindsExactPosesFromFarAway) {
  const StereoRig rig = nominal_rig(PenRig::Global);
  const Pen pen;
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const PenPose truth = random_pose(random);
    std::vector<LedImage> images = images_of(rig, pen, truth, 0, random);
    for (LedImage& image : images) image.blob.covariance = 1e-4 * Eigen::Matrix2d::Identity();
    const PenPose start{truth.tip + 0.02 * random.direction(),
                        (truth.direction + 0.2 * random.direction()).normalized()};
    const auto found = fit_pose(rig, pen, images, start);
    ASSERT_TRUE(found);
    EXPECT_LT((found->pose.tip - truth.tip).norm(), 1e-8);
    EXPECT_LT((found->pose.direction - truth.direction).norm(), 1e-7);
  }
}

// The Cramér–Rao bound: no estimate without bias is better, and this one is not 5 % worse. The errors by
// their own covariance have five degrees of freedom.
TEST(FitPose, AttainsTheCramerRaoBound) {
  const StereoRig rig = nominal_rig(PenRig::Global);
  const Pen pen;
  Random random(2);
  double squares = 0, bounds = 0, chi_square = 0, residual = 0;
  const int n = 2000;
  for (int trial = 0; trial < n; ++trial) {
    const PenPose truth = random_pose(random);
    const std::vector<LedImage> images = images_of(rig, pen, truth, 0.05, random);
    const auto found = fit_pose(rig, pen, images, truth);
    ASSERT_TRUE(found);
    const PenInformation bound = pose_information(rig, pen, truth, images).inverse();
    squares += (found->pose.tip - truth.tip).squaredNorm();
    bounds += bound.topLeftCorner<3, 3>().trace();
    Eigen::Matrix<double, 5, 1> off;
    off << truth.tip - found->pose.tip,
        tangent_basis(found->pose.direction).transpose() * (truth.direction - found->pose.direction);
    chi_square += off.dot(found->covariance.ldlt().solve(off)) / n;
    residual += found->chi_square / n;
  }
  EXPECT_NEAR(std::sqrt(squares / bounds), 1, 0.05);
  EXPECT_NEAR(chi_square, 5, 0.3);
  EXPECT_NEAR(residual, 16 - 5, 0.5);
}

// One camera that sees three LEDs fixes all five unknowns, along its rays only weakly.
TEST(FitPose, OneCameraIsEnoughAndSaysHowWell) {
  const StereoRig rig = nominal_rig(PenRig::Global);
  const Pen pen;
  Random random(3);
  const PenPose truth = random_pose(random);
  std::vector<LedImage> images = images_of(rig, pen, truth, 0.01, random);
  const auto both = fit_pose(rig, pen, images, truth);
  images.resize(3);
  const auto one = fit_pose(rig, pen, images, truth);
  ASSERT_TRUE(both);
  ASSERT_TRUE(one);
  EXPECT_GT(one->tip_covariance().trace(), 9 * both->tip_covariance().trace());
  images.resize(2);
  EXPECT_FALSE(fit_pose(rig, pen, images, truth)) << "four numbers do not determine five";
}

// H (4.11)–(4.13) on exact points, in whatever sense they are given.
TEST(PoseOfPoints, FindsTipAndSense) {
  const Pen pen;
  const PenPose truth{{0.1, 0.2, 0.7}, Eigen::Vector3d(0.3, -0.9, 0.2).normalized()};
  const std::array<int, 3> leds = {3, 0, 2};
  std::array<Eigen::Vector3d, 3> points;
  for (std::size_t i = 0; i < 3; ++i) points[i] = led_position(pen, truth, leds[i]);
  const PenPose found = pose_of_points(pen, leds, points);
  EXPECT_LT((found.tip - truth.tip).norm(), 1e-12);
  EXPECT_LT((found.direction - truth.direction).norm(), 1e-12);
}

}  // namespace
}  // namespace batten::test
