#include "batten/pipeline/calibrated_rig.hpp"

#include "camera/board_images.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::test {
namespace {

TEST(CalibratedRig, ChecksItselfAndWarnsOfWhatIsPoor) {
  const CalibratedRigRun good = calibrated_rig(shown_boards(usual_rig(), {.pairs = 16, .noise = 0.1}));
  for (const std::string& warning : good.warnings)
    EXPECT_NE(warning.find("the board covers"), std::string::npos) << warning;
  EXPECT_NEAR(good.check.epipolar, good.calibration.calibrated.figures.epipolar, 1e-12);
  EXPECT_NEAR(good.check.neighbour_mean, 1, 0.001);
  EXPECT_GT(good.times.total(), 0);
  const CalibratedRigRun poor = calibrated_rig(shown_boards(usual_rig(), {.pairs = 12, .noise = 2.0}));
  std::string all;
  for (const std::string& warning : poor.warnings) all += warning + "\n";
  EXPECT_NE(all.find("pixels (rms)"), std::string::npos) << all;
}

BoardPhotograph photograph(int pair, bool right, const GreyImage& image) {
  return {concat(right ? "right" : "left", pair, ".png"), pair, right, image};
}

TEST(BoardsInImages, LeavesOutWithTheReason) {
  StereoRig rig = usual_rig();
  for (Camera* camera : {&rig.left, &rig.right}) {  // half the size: a quarter of the rays to trace
    camera->width /= 2;
    camera->height /= 2;
    for (double* number : {&camera->fx, &camera->fy, &camera->cx, &camera->cy}) *number /= 2;
  }
  const Board board{.columns = 9, .rows = 6, .square = 0.03};
  std::vector<BoardPhotograph> photographs;
  for (int pair = 1; pair <= 5; ++pair) {
    const Eigen::Matrix3d R = so3_exp(Eigen::Vector3d(0.1 * pair, -0.2, 0.1));
    const Eigen::Vector3d t = Eigen::Vector3d(0.1, 0, 0.7) - R * Eigen::Vector3d(0.12, 0.075, 0);
    photographs.push_back(photograph(pair, false, picture_of(rig.left, board, R, t)));
    photographs.push_back(photograph(
        pair, true, picture_of(rig.right, board, rig.rotation * R, rig.rotation * t + rig.translation)));
  }
  photographs.push_back(photograph(6, true, photographs[0].image));
  photographs[3].image.pixels.assign(photographs[3].image.pixels.size(), 90);  // right2
  const FoundBoards found = boards_in_images(photographs, board);
  EXPECT_EQ(found.pairs.pairs.size(), 4U);
  ASSERT_EQ(found.warnings.size(), 2U);
  EXPECT_NE(found.warnings[0].find("right2.png is left out: no chessboard"), std::string::npos);
  EXPECT_NE(found.warnings[1].find("no left image of pair 6"), std::string::npos);
  EXPECT_LT(check_rig(rig, found.pairs).epipolar_rms, 0.1);

  photographs[5].image.pixels.assign(photographs[5].image.pixels.size(), 90);
  EXPECT_NE(refusal([&] { boards_in_images(photographs, board); }).find("3 of 6 can be used"),
            std::string::npos);
  const GreyImage image = photographs[7].image;
  photographs[7].image = {2, 2, {1, 2, 3, 4}};
  EXPECT_NE(refusal([&] { boards_in_images(photographs, board); }).find("one size"), std::string::npos);
  photographs[7].image = image;
  photographs[9].pair = 4;
  EXPECT_NE(refusal([&] { boards_in_images(photographs, board); }).find("both the right image"),
            std::string::npos);
}

}  // namespace
}  // namespace batten::test
