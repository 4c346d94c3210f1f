#include "batten/io/rig_io.hpp"

#include "camera/rigs.hpp"
#include "io/bad_files.hpp"
#include "scratch.hpp"

#include <fstream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten::test {
namespace {

/// With a value of its own in every field.
CalibratedRig full_rig() {
  CalibratedRig rig;
  rig.rig = webcam_rig();
  rig.rig.right.height = 481;
  RigFigures& figures = rig.figures;
  figures.board = {.columns = 7, .rows = 4, .square = 0.031};
  figures.lens = LensModel::Full;
  figures.pairs = 11;
  figures.corners = 308;
  figures.left_out = 3;
  double value = 1.0 / 3;
  for (double* number :
       {&figures.left_rms, &figures.right_rms, &figures.rms, &figures.epipolar, &figures.epipolar_rms,
        &figures.held_back, &figures.left_coverage, &figures.right_coverage, &figures.tilt})
    *number = value *= 1.1;
  for (Camera* camera : {&figures.deviations.left, &figures.deviations.right})
    for (double* number : {&camera->fx, &camera->fy, &camera->cx, &camera->cy, &camera->k1, &camera->k2,
                           &camera->k3, &camera->p1, &camera->p2})
      *number = value *= 1.1;
  figures.deviations.rotation = Eigen::Vector3d(1, 2, 3) / 7e5;
  figures.deviations.translation = Eigen::Vector3d(3, 2, 1) / 7e5;
  return rig;
}

std::string message(const std::string& text) {
  try {
    parse_rig(text, "rig.json");
  } catch (const FileError& error) {
    return error.what();
  }
  return {};
}

// Written again, the same bytes: no field is lost or confused with another, for each has a value of its own.
TEST(RigFile, ReadsBackBitForBit) {
  const std::string first = scratch_file("first.json"), second = scratch_file("second.json");
  write_rig(full_rig(), first);
  const CalibratedRig read = read_rig(first);
  write_rig(read, second);
  EXPECT_EQ(read_file(first), read_file(second));
  EXPECT_EQ(read.rig.rotation, full_rig().rig.rotation);
  EXPECT_EQ(read.rig.translation, full_rig().rig.translation);
  EXPECT_EQ(read.rig.left.k2, full_rig().rig.left.k2);
  EXPECT_EQ(read.rig.right.height, 481);
  EXPECT_EQ(read.figures.deviations.right.p2, full_rig().figures.deviations.right.p2);
  EXPECT_EQ(read.figures.tilt, full_rig().figures.tilt);
}

TEST(RigFile, NeedsNoFiguresOfACalibration) {
  CalibratedRig rig = full_rig();
  rig.figures.pairs = 0;
  const std::string path = scratch_file("bare.json");
  write_rig(rig, path);
  EXPECT_EQ(read_file(path).find("calibration"), std::string::npos);
  EXPECT_EQ(read_rig(path).figures.pairs, 0);
}

TEST(RigFile, SaysWhatIsWrongAndWhatHelps) {
  const std::string path = scratch_file("rig.json");
  write_rig(full_rig(), path);
  const std::string good = read_file(path);
  ASSERT_EQ(message(good), "");
  EXPECT_NE(message("{").find("valid JSON"), std::string::npos);
  EXPECT_NE(message("[]").find("no stereo rig"), std::string::npos);
  EXPECT_NE(message(replaced(good, "batten rig", "other rig")).find("batten rig calibrate"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"version\": 1", "\"version\": 2")).find("newer batten"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"fx\"", "\"f\"")).find("left.fx is missing"), std::string::npos);
  EXPECT_NE(message(replaced(good, "\"width\": 640", "\"width\": 0")).find("left camera: width"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"rotation\": [", "\"rotation\": [[1, 0, 0],")).find("3 rows"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"lens\": \"full\"", "\"lens\": \"fish\"")).find("calibration.lens"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"columns\": 7", "\"columns\": 8")).find("half a turn"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"pairs\": 11", "\"pairs\": 1.5")).find("calibration.pairs"),
            std::string::npos);
  EXPECT_NE(message(replaced(good, "\"p2\": ", "\"p2\": 1e999, \"old\": ")).find("out of range"),
            std::string::npos);
  CalibratedRig bad = full_rig();
  bad.rig.translation.setZero();
  EXPECT_THROW(write_rig(bad, path), InvalidInput);
}

const CornersOptions kSized{.board = {}, .size = ImageSize{640, 480}};

// A corner in the middle of the first pixel: (0, 0) in the file, (0.5, 0.5) here.
TEST(Corners, TakeTheMiddleOfTheFirstPixelForZero) {
  const BoardPairs pairs = parse_corners(
      "# pair,camera,corner,col,row,x_px,y_px ; 9x6 inner corners\n3,left,0,0,0,0,0\n3,right,10,1,1,7.25,8\n",
      "c.csv", kSized);
  ASSERT_EQ(pairs.pairs.size(), 1U);
  const BoardPair& pair = pairs.pairs[0];
  EXPECT_EQ(pair.number, 3);
  EXPECT_EQ(pair.left.row(0), Eigen::RowVector2d(0.5, 0.5));
  EXPECT_EQ(pair.right.row(10), Eigen::RowVector2d(7.75, 8.5));
  EXPECT_TRUE(pair.in_left(0));
  EXPECT_FALSE(pair.in_right(0));
  EXPECT_EQ(pair.n_common(), 0);
}

TEST(Corners, KnowColumnsByNameOrByPlace) {
  const BoardPairs plain = parse_corners("1,left,2,1,100,200\n", "c.csv", kSized);
  EXPECT_EQ(plain.pairs[0].left.row(11), Eigen::RowVector2d(100.5, 200.5));
  const BoardPairs named = parse_corners("v,u,row,column,side,pair\n200,100,1,2,LEFT,1\n\n", "c.csv", kSized);
  EXPECT_EQ(named.pairs[0].left.row(11), Eigen::RowVector2d(100.5, 200.5));
}

TEST(Corners, TakeTheSizeOfTheImagesFromFileOrGuess) {
  std::vector<std::string> warnings;
  const std::string row = "1,left,2,1,800,200\n";
  EXPECT_EQ(parse_corners("# image_size: 1000x900\n" + row, "c.csv", {}, &warnings).left_height, 900);
  EXPECT_TRUE(warnings.empty());
  const BoardPairs guessed = parse_corners(row, "c.csv", {}, &warnings);
  EXPECT_EQ(guessed.right_width, 1024);
  EXPECT_EQ(guessed.right_height, 768);
  // 320 x 240 is wide enough and too low.
  const BoardPairs low = parse_corners("1,left,2,1,300,470\n", "c.csv", {});
  EXPECT_EQ(low.left_width, 640);
  EXPECT_EQ(low.left_height, 480);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("--image-size"), std::string::npos);
  EXPECT_EQ(parse_image_size("640x480").width, 640);
  for (const char* text : {"640", "x", "0x480", "640x480x3", "-640x480"})
    EXPECT_THROW(parse_image_size(text), InvalidInput) << text;
}

TEST(Corners, OptionsNameBoardAndSize) {
  CornersOptions options;
  EXPECT_EQ(options.problem(), std::nullopt);
  options.size = ImageSize{640, 0};
  EXPECT_EQ(options.problem(), "size must be at least 1x1 pixels, got 640x0");
  EXPECT_THROW(parse_corners("", "corners.csv", options), InvalidInput);
  options.board.rows = 1;
  EXPECT_EQ(options.problem(), options.board.problem());
}

TEST(Corners, AreRefusedWithTheLine) {
  const auto said = [](const std::string& text) {
    try {
      parse_corners(text, "c.csv", kSized);
    } catch (const FileError& error) {
      return concat(error.line(), ": ", error.what());
    }
    return std::string();
  };
  EXPECT_NE(said("").find("holds no corners"), std::string::npos);
  EXPECT_EQ(said("1,left,0,0,1,1\n1,left,0,0,2,2\n").substr(0, 2), "2:");
  EXPECT_NE(said("1,left,9,0,1,1\n").find("--board"), std::string::npos);
  EXPECT_NE(said("1,left,0,6,1,1\n").find("--board"), std::string::npos);
  EXPECT_NE(said("1,middle,0,0,1,1\n").find("left or right"), std::string::npos);
  EXPECT_NE(said("1,left,0,0,nan,1\n").find("number of pixels"), std::string::npos);
  EXPECT_NE(said("1,left,0,0,1\n").find("6 fields"), std::string::npos);
  EXPECT_NE(said("1,left,0,0,700,1\n").find("outside of the left image"), std::string::npos);
  EXPECT_NE(said("1,left,0,0,1,1\npair,side,col,row,u,v\n").find("names the columns"), std::string::npos);
  EXPECT_THROW(parse_corners("1,left,0,0,1,1\n", "c.csv", {.board = {.columns = 8}, .size = {}}),
               InvalidInput);
}

TEST(Corners, AreReadBackAsWritten) {
  BoardPairs pairs;
  pairs.left_width = pairs.right_width = 640;
  pairs.left_height = pairs.right_height = 480;
  BoardPair pair;
  pair.number = 5;
  pair.left = BoardCorners::Constant(54, 2, std::numeric_limits<double>::quiet_NaN());
  pair.right = pair.left;
  pair.left.row(3) << 12.34567890123, 400.5;
  pair.right.row(53) << 639.75, 0.5;
  pairs.pairs = {pair};
  const std::string path = scratch_file("corners.csv");
  write_corners(pairs, path);
  const BoardPairs read = read_corners(path, {});
  EXPECT_EQ(read.left_width, 640);
  EXPECT_NEAR(read.pairs[0].left(3, 0), 12.34567890123, 1e-13);
  EXPECT_EQ(read.pairs[0].right.row(53), pair.right.row(53));
  EXPECT_FALSE(read.pairs[0].in_right(3));
  pairs.right_width = 641;
  EXPECT_THROW(write_corners(pairs, path), InvalidInput);
}

}  // namespace
}  // namespace batten::test
