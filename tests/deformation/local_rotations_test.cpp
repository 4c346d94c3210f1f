#include "batten/deformation/local_rotations.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rotations found by Newton against construction: R·S with S symmetric positive definite has the rotation R.
TEST(NearestRotation, FindsTheRotationOfAPolarProduct) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d R = Eigen::AngleAxisd(random.uniform(-kPi, kPi), random.direction()).toRotationMatrix();
    Matrix3d A;
    for (int k = 0; k < 3; ++k) A.col(k) = random.normal3();
    const Matrix3d S = A * A.transpose() + 0.01 * Matrix3d::Identity();
    EXPECT_LT((nearest_rotation(R * S) - R).norm(), 1e-6) << i;
  }
}

// A mirrored set has no rotation that fits; the result must still be one.
TEST(NearestRotation, IsARotationForMirroredAndFlatSets) {
  for (const Vector3d& diagonal :
       {Vector3d(1, 1, -1), Vector3d(3, 2, 0), Vector3d(1, 0, 0), Vector3d(-1, -1, -1)}) {
    const Matrix3d R = nearest_rotation(diagonal.asDiagonal().toDenseMatrix());
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
    EXPECT_LT((R * R.transpose() - Matrix3d::Identity()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace batten
