#include "batten/camera/chessboard.hpp"

#include "camera/board_images.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

const Board kBoard{.columns = 9, .rows = 6, .square = 0.03};

Camera small_camera() {
  Camera camera = webcam();
  camera.width = 320;
  camera.height = 240;
  camera.fx /= 2;
  camera.fy /= 2;
  camera.cx /= 2;
  camera.cy /= 2;
  return camera;
}

/// The board in the middle of the image, turned about the axis of the camera and tilted.
struct Pose {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
};
Pose pose(double turn, double tilt, double distance = 0.45) {
  const Eigen::Matrix3d R =
      so3_exp(tilt * Eigen::Vector3d(0.6, -0.8, 0)) * so3_exp(Eigen::Vector3d(0, 0, turn));
  return {R, Eigen::Vector3d(0.005, -0.003, distance) - R * Eigen::Vector3d(0.12, 0.075, 0)};
}

BoardCorners true_corners(const Camera& camera, const Pose& pose) {
  BoardCorners corners(kBoard.n_corners(), 2);
  for (int i = 0; i < kBoard.n_corners(); ++i)
    corners.row(i) = project(camera, pose.R * kBoard.corner(i) + pose.t).transpose();
  return corners;
}

double rms(const BoardCorners& a, const BoardCorners& b) {
  return (a - b).norm() / std::sqrt(static_cast<double>(a.rows()));
}

// Counted from the same corner whichever way up the board is held: also upside down, where position alone
// would mislead. The error of a corner is about noise · blur / contrast of its neighbourhood, hundredths of a
// pixel.
TEST(FindChessboard, FindsEveryCornerInItsPlaceHoweverTheBoardIsTurned) {
  const Camera camera = small_camera();
  for (const double turn : {0.0, 0.7, 1.5, 2.4, kPi, -2.0, -0.9}) {
    const Pose at = pose(turn, 0.5);
    const ChessboardSearch search = find_chessboard(picture_of(camera, kBoard, at.R, at.t), kBoard);
    ASSERT_TRUE(search.corners) << turn << ": " << search.reason;
    EXPECT_LT(rms(*search.corners, true_corners(camera, at)), 0.06) << turn;
    EXPECT_NEAR(search.contrast, 80, 8);
    EXPECT_LT(search.blur, 1.2);
  }
}

TEST(FindChessboard, MeasuresAndRefusesBlur) {
  const Camera camera = small_camera();
  const Pose at = pose(0.2, 0.3);
  const ChessboardSearch soft = find_chessboard(picture_of(camera, kBoard, at.R, at.t, {.blur = 1}), kBoard);
  ASSERT_TRUE(soft.corners) << soft.reason;
  EXPECT_NEAR(soft.blur, std::sqrt(2 * 1 * 2 / 3.0), 0.4);  // the variance of two boxes
  const ChessboardSearch blurred = find_chessboard(picture_of(camera, kBoard, at.R, at.t, {.blur = 2}),
                                                   kBoard, {.contrast = 10, .blur = 0.01});
  EXPECT_FALSE(blurred.corners && blurred.blur > 2);
  const ChessboardSearch lost = find_chessboard(picture_of(camera, kBoard, at.R, at.t, {.blur = 4}), kBoard);
  EXPECT_FALSE(lost.corners);
  EXPECT_FALSE(lost.reason.empty());
}

TEST(FindChessboard, RefusesWhatIsDarkHiddenOrAnotherBoard) {
  const Camera camera = small_camera();
  const Pose at = pose(0.2, 0.3);
  const auto reason = [&](const PictureOptions& options, const Board& board = kBoard) {
    const ChessboardSearch search = find_chessboard(picture_of(camera, kBoard, at.R, at.t, options), board);
    EXPECT_FALSE(search.corners);
    return search.reason;
  };
  EXPECT_NE(reason({.bright = 42, .dark = 30, .noise = 1}).find("dark"), std::string::npos);
  EXPECT_NE(reason({.missing = 0.2}).find("the board has 9x6"), std::string::npos);
  EXPECT_NE(reason({}, {.columns = 8, .rows = 5}).find("9x6 with 54 corners"), std::string::npos);
  EXPECT_NE(reason({}, {.columns = 10, .rows = 7}).find("9x6 with 54 corners"), std::string::npos);
  GreyImage empty{320, 240, std::vector<std::uint8_t>(320 * 240, 128)};
  EXPECT_NE(find_chessboard(empty, kBoard).reason.find("no chessboard"), std::string::npos);
  EXPECT_FALSE(find_chessboard(GreyImage{1, 1, {7}}, kBoard).corners);
  EXPECT_FALSE(find_chessboard(GreyImage{}, kBoard).corners);
}

TEST(FindChessboard, RefusesBadOptions) {
  EXPECT_THROW(find_chessboard({}, kBoard, {.contrast = 0}), InvalidInput);
  EXPECT_THROW(find_chessboard({}, kBoard, {.contrast = 10, .blur = 0}), InvalidInput);
  EXPECT_THROW(find_chessboard({}, {.columns = 8, .rows = 6}), InvalidInput);
}

}  // namespace
}  // namespace batten::test
