#include "batten/camera/rig.hpp"

#include "camera/rigs.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

TEST(StereoRig, ImagesOfOnePointLieOnEachOthersLines) {
  const StereoRig rig = test::webcam_rig();
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point(random.uniform(-0.1, 0.2), random.uniform(-0.2, 0.2),
                                random.uniform(0.4, 1.5));
    const auto distance = epipolar_distance(rig, project(rig.left, point),
                                            project(rig.right, rig.rotation * point + rig.translation));
    ASSERT_TRUE(distance);
    EXPECT_LT(*distance, 1e-8);
  }
}

TEST(StereoRig, EpipolarDistanceOfAVerticalShiftIsThatShift) {
  // Parallel cameras side by side: the lines are rows, and a right pixel three rows lower is three pixels off
  // both.
  StereoRig rig;
  rig.left.width = rig.left.height = 200;
  rig.left.fx = rig.left.fy = 150;
  rig.left.cx = rig.left.cy = 100;
  rig.right = rig.left;
  rig.translation = {-0.2, 0, 0};
  const auto distance = epipolar_distance(rig, {110, 80}, {60, 83});
  ASSERT_TRUE(distance);
  EXPECT_NEAR(*distance, 3, 1e-12);
  EXPECT_NEAR(rig.right_centre().x(), 0.2, 1e-15);
}

TEST(StereoRig, ProblemsNameWhatIsWrong) {
  EXPECT_EQ(problem(test::webcam_rig()), "");
  StereoRig rig = test::webcam_rig();
  rig.rotation *= 1.01;
  EXPECT_NE(problem(rig).find("rotation"), std::string::npos);
  rig = test::webcam_rig();
  rig.rotation.col(0) *= -1;
  EXPECT_NE(problem(rig).find("rotation"), std::string::npos);
  rig = test::webcam_rig();
  rig.translation.setZero();
  EXPECT_NE(problem(rig).find("one place"), std::string::npos);
  rig = test::webcam_rig();
  rig.right.fx = 0;
  EXPECT_EQ(problem(rig).rfind("right camera: fx", 0), 0u);
}

}  // namespace
}  // namespace batten
