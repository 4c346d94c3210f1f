#include "batten/camera/pen.hpp"

#include "camera/rigs.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/camera/blobs.hpp"

namespace batten::test {
namespace {

TEST(Pen, LedsLieOnItsAxis) {
  const Pen pen;
  const PenPose pose{{0.1, 0.2, 0.7}, Eigen::Vector3d(1, -2, 0.5).normalized()};
  for (int led = 0; led < kPenLeds; ++led) {
    const Eigen::Vector3d off = led_position(pen, pose, led) - pose.tip;
    EXPECT_NEAR(off.norm(), 0.06 + pen.leds[static_cast<std::size_t>(led)], 1e-15);
    EXPECT_LT(off.cross(pose.direction).norm(), 1e-15);
  }
}

TEST(Pen, SaysWhatIsWrong) {
  Pen pen;
  EXPECT_EQ(problem(pen), "");
  pen.leds[2] = 0.05;
  EXPECT_NE(problem(pen).find("leds[2]"), std::string::npos);
  pen = {};
  pen.tip_offset = -1;
  EXPECT_NE(problem(pen).find("tip_offset"), std::string::npos);
}

TEST(TangentBasis, IsOrthonormal) {
  for (const Eigen::Vector3d& d :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0.6, 0, 0.8)}) {
    Eigen::Matrix3d all;
    all << tangent_basis(d), d;
    EXPECT_LT((all.transpose() * all - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  }
}

// The derivative by central differences, in both cameras; nothing behind them.
TEST(ImageIn, HasTheDerivativeThatItSays) {
  const StereoRig rig = webcam_rig();
  const Eigen::Vector3d point(0.05, -0.04, 0.8);
  for (const CameraSide side : {CameraSide::Left, CameraSide::Right}) {
    Eigen::Matrix<double, 2, 3> jacobian;
    ASSERT_TRUE(image_in(rig, side, point, &jacobian));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d h = 1e-6 * Eigen::Vector3d::Unit(k);
      const Eigen::Vector2d difference =
          (*image_in(rig, side, point + h) - *image_in(rig, side, point - h)) / 2e-6;
      EXPECT_LT((difference - jacobian.col(k)).norm(), 1e-4);
    }
    EXPECT_FALSE(image_in(rig, side, -point));
  }
}

}  // namespace
}  // namespace batten::test
