#include "batten/rotation/so3.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

Eigen::Vector3d rotation_vector(Random& random, double longest) {
  return random.uniform(0, longest) * random.direction();
}

TEST(So3, ExpIsARotationAndAgreesWithEigensAngleAxis) {
  // Eigen's angle-axis conversion is a second implementation.
  Random random(1);
  for (const double longest : {1e-9, 1e-3, 0.019, 0.021, 1.0, kPi, 10.0}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d a = rotation_vector(random, longest);
      const Eigen::Matrix3d R = so3_exp(a);
      EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
      const Eigen::Matrix3d expected = Eigen::AngleAxisd(a.norm(), a.normalized()).toRotationMatrix();
      EXPECT_LT((R - expected).norm(), 3e-15 * (1 + longest));
    }
  }
  EXPECT_EQ(so3_exp(Eigen::Vector3d::Zero()), Eigen::Matrix3d::Identity());
}

TEST(So3, LogInvertsExpForEveryAngleUpToPi) {
  Random random(2);
  for (const double angle : {0.0, 1e-12, 1e-6, 0.02, 1.0, 3.0, kPi - 1e-6, kPi - 1e-9}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d a = angle * random.direction();
      EXPECT_LT((so3_log(so3_exp(a)) - a).norm(), 1e-13 * (1 + angle)) << angle;
    }
  }
  // At exactly π both signs of the axis are right: compare the rotations.
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d R = so3_exp(kPi * random.direction());
    EXPECT_LT((so3_exp(so3_log(R)) - R).norm(), 1e-13);
  }
}

TEST(So3, RightJacobianIsTheDerivativeOfExp) {
  // Central differences of order h², h = 1e-5: error about 1e-10.
  Random random(3);
  for (const double longest : {1e-4, 0.03, 1.0, 3.0}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d a = rotation_vector(random, longest), d = random.direction();
      const double h = 1e-5;
      const Eigen::Matrix3d R = so3_exp(a);
      const Eigen::Vector3d difference =
          (so3_log(R.transpose() * so3_exp(a + h * d)) - so3_log(R.transpose() * so3_exp(a - h * d))) /
          (2 * h);
      EXPECT_LT((so3_right_jacobian(a) * d - difference).norm(), 1e-9);
      EXPECT_LT((so3_right_jacobian_inverse(a) * so3_right_jacobian(a) - Eigen::Matrix3d::Identity()).norm(),
                1e-11);
    }
  }
}

TEST(So3, NearestRotationLeavesRotationsAndUndoesStretching) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix3d R = so3_exp(rotation_vector(random, 3));
    EXPECT_LT((nearest_rotation(R) - R).norm(), 1e-14);
    // The polar decomposition R P with P symmetric positive definite has R as its nearest rotation.
    const Eigen::Matrix3d Q = so3_exp(rotation_vector(random, 3));
    const Eigen::Matrix3d P = Q * Eigen::Vector3d(0.5, 1, 2).asDiagonal() * Q.transpose();
    EXPECT_LT((nearest_rotation(R * P) - R).norm(), 1e-13);
    // A reflection has no rotation as its polar factor, and still a rotation comes back.
    EXPECT_NEAR(nearest_rotation(-R * P).determinant(), 1, 1e-13);
  }
}

TEST(So3, DarbouxFrameHasColumnsTangentNormalAndTheirProduct) {
  const Eigen::Vector3d t(2, 0, 0), N(0.3, 0, 3);
  const Eigen::Matrix3d keep = darboux_frame(t, N);
  EXPECT_LT((keep.col(1) - N.normalized()).norm(), 1e-15);
  const Eigen::Matrix3d turn = darboux_frame(t, N, false);
  EXPECT_LT((turn.col(0) - Eigen::Vector3d::UnitX()).norm(), 1e-15);
  for (const Eigen::Matrix3d& X : {keep, turn}) {
    EXPECT_NEAR(X.determinant(), 1, 1e-14);
    EXPECT_LT((X.col(2) - X.col(0).cross(X.col(1))).norm(), 1e-14);  // B = t × N
    EXPECT_GT(X.col(0).dot(t), 0);
  }
}

TEST(So3, DarbouxFrameRefusesVanishingAndParallelVectors) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), zero = Eigen::Vector3d::Zero();
  EXPECT_THROW(darboux_frame(zero, x), InvalidInput);
  EXPECT_THROW(darboux_frame(x, zero), InvalidInput);
  EXPECT_THROW(darboux_frame(x, -2 * x), InvalidInput);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(darboux_frame(x, Eigen::Vector3d(nan, 0, 1)), InvalidInput);
}

// The limit is a sine of 1e-4 between the two, whatever their lengths and on whichever side they are: a tenth
// below it is refused, a tenth above it gives a frame that is orthonormal to rounding over that sine.
TEST(So3, DarbouxFrameTakesDirectionsDownToASineOfOneInTenThousand) {
  for (const double side : {1.0, -1.0}) {
    for (const double length : {1e-6, 1.0, 1e6}) {
      const auto normal = [&](double sine) -> Eigen::Vector3d {
        return length * Eigen::Vector3d(side * std::sqrt(1 - sine * sine), sine, 0);
      };
      const Eigen::Vector3d t(3, 0, 0);
      EXPECT_THROW(darboux_frame(t, normal(0.9e-4)), InvalidInput);
      EXPECT_THROW(darboux_frame(t, normal(0.9e-4), false), InvalidInput);
      for (const bool keep_normal : {true, false}) {
        const Eigen::Matrix3d X = darboux_frame(t, normal(1.1e-4), keep_normal);
        EXPECT_LT((X.transpose() * X - Eigen::Matrix3d::Identity()).norm(), 1e-11);
        EXPECT_LT((X.col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-11);  // x × (±1, 1e-4, 0) points to z
      }
    }
  }
}

}  // namespace
}  // namespace batten
