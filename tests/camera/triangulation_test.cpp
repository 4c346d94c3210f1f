#include "batten/camera/triangulation.hpp"

#include "camera/rigs.hpp"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

constexpr Triangulation kAll[] = {Triangulation::Midpoint, Triangulation::Depths, Triangulation::Linear,
                                  Triangulation::Reprojection};

Eigen::Vector2d in_right(const StereoRig& rig, const Eigen::Vector3d& point) {
  return project(rig.right, rig.rotation * point + rig.translation);
}

TEST(Triangulate, FindsExactPointsByEveryMethod) {
  const StereoRig rig = test::webcam_rig();
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d point(random.uniform(-0.1, 0.2), random.uniform(-0.2, 0.2),
                                random.uniform(0.4, 1.5));
    for (const Triangulation method : kAll) {
      const auto found = triangulate(rig, project(rig.left, point), in_right(rig, point), method);
      ASSERT_TRUE(found);
      EXPECT_LT((found->position - point).norm(), 1e-9) << word_of(method);
      EXPECT_LT(found->reprojection, 1e-7);
    }
  }
}

TEST(Triangulate, ReprojectionIsNeverWorseInTheImages) {
  const StereoRig rig = test::webcam_rig();
  const Eigen::Vector3d point(0.05, 0.1, 0.7);
  Random random(6);
  const auto residual = [&](const Eigen::Vector3d& X, const Eigen::Vector2d& l, const Eigen::Vector2d& r) {
    return (project(rig.left, X) - l).squaredNorm() + (in_right(rig, X) - r).squaredNorm();
  };
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d left = project(rig.left, point) + Eigen::Vector2d(random.normal(), random.normal());
    const Eigen::Vector2d right = in_right(rig, point) + Eigen::Vector2d(random.normal(), random.normal());
    const double least =
        residual(triangulate(rig, left, right, Triangulation::Reprojection)->position, left, right);
    for (const Triangulation method : kAll)
      EXPECT_LE(least, residual(triangulate(rig, left, right, method)->position, left, right) + 1e-9);
  }
}

TEST(Triangulate, CovarianceIsThatOfManyTrials) {
  const StereoRig rig = test::webcam_rig();
  const Eigen::Vector3d point(0.1, -0.05, 0.8);
  constexpr double kSigma = 0.1;
  Random random(7);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  constexpr int kTrials = 4000;
  for (int i = 0; i < kTrials; ++i) {
    const auto found = triangulate(
        rig, project(rig.left, point) + kSigma * Eigen::Vector2d(random.normal(), random.normal()),
        in_right(rig, point) + kSigma * Eigen::Vector2d(random.normal(), random.normal()),
        Triangulation::Reprojection);
    sum += (found->position - point) * (found->position - point).transpose();
  }
  const Eigen::Matrix3d expected =
      kSigma * kSigma * triangulate(rig, project(rig.left, point), in_right(rig, point))->covariance;
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sum(k, k) / kTrials / expected(k, k), 1, 0.1);
  // Depth is what two cameras see worst: σ_z ≈ z² σ √2 / (f b).
  EXPECT_NEAR(std::sqrt(expected(2, 2)), 0.64 * kSigma * std::sqrt(2) / (537 * 0.25), 2e-4);
}

TEST(Triangulate, RefusesParallelRaysAndPointsBehindACamera) {
  StereoRig rig = test::webcam_rig();
  rig.right = rig.left;
  rig.rotation.setIdentity();
  rig.translation = {-0.25, 0, 0};
  for (const Triangulation method : kAll) {
    EXPECT_FALSE(triangulate(rig, {300, 200}, {300, 200}, method));  // at infinity
    EXPECT_FALSE(triangulate(rig, {300, 200}, {340, 200}, method));  // rays that part in front
    EXPECT_TRUE(triangulate(rig, {340, 200}, {300, 200}, method));
  }
}

}  // namespace
}  // namespace batten
