#include "batten/io/blobs_io.hpp"

#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

const std::string kHeader = "{\"format\":\"batten blobs\",\"version\":1,\"width\":640,\"height\":480}\n";
const std::string kFrame = "{\"time\":0.5,\"camera\":\"left\",\"blobs\":[[1.5,2.5,0.01,0.001,0.02],[3,4]]}\n";

std::string blobs_error(const std::string& text) {
  try {
    parse_blobs(text, "b.jsonl");
  } catch (const FileError& error) {
    return error.what();
  }
  return {};
}

TEST(BlobsIo, ReadsBackWhatItWrites) {
  BlobRecording recording;
  recording.width = 640;
  recording.height = 480;
  Blob blob{{0.1, 1.0 / 3}, Eigen::Matrix2d::Identity() * 0.3};
  blob.covariance(0, 1) = blob.covariance(1, 0) = 0.1 / 3;
  recording.frames.push_back({0.1, CameraSide::Left, {blob, blob}});
  recording.frames.push_back({0.1, CameraSide::Right, {}});
  recording.inertial.push_back({0.05, {1e-3, 2, 3}, {0, -9.81, 1e-17}});
  recording.buttons.push_back({0.02, "draw", true});
  recording.buttons.push_back({0.2, "draw", false});
  const std::string text = format_blobs(recording);
  const BlobRecording read = parse_blobs(text, "b.jsonl");
  EXPECT_EQ(format_blobs(read), text);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].blobs[1].pixel, blob.pixel);
  EXPECT_EQ(read.frames[0].blobs[1].covariance, blob.covariance);
  EXPECT_EQ(read.inertial[0].accelerometer.z(), 1e-17);
  EXPECT_FALSE(read.buttons[1].down);
}

TEST(BlobsIo, FramesMayNameAnImageInstead) {
  const std::string line = R"({"time":0.5,"camera":"right","image":"right \"1\".pgm"})"
                           "\n";
  const BlobRecording read = parse_blobs(kHeader + kFrame + line, "b.jsonl");
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].image, "");
  EXPECT_EQ(read.frames[1].image, "right \"1\".pgm");
  EXPECT_TRUE(read.frames[1].blobs.empty());
  EXPECT_EQ(parse_blobs(format_blobs(read), "b.jsonl").frames[1].image, read.frames[1].image);
  EXPECT_NE(blobs_error(kHeader + "{\"time\":1,\"camera\":\"left\",\"image\":7}\n").find("image"),
            std::string::npos);
}

TEST(BlobsIo, PutsFramesInOrderAndLeavesOutATornLine) {
  std::vector<std::string> notes;
  const BlobRecording read = parse_blobs(
      kHeader + kFrame + "{\"time\":0.25,\"camera\":\"right\",\"blobs\":[]}\n" + "{\"time\":0.7,\"cam",
      "b.jsonl", &notes);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].camera, CameraSide::Right);
  EXPECT_EQ(read.frames[1].blobs.size(), 2u);
  EXPECT_EQ(read.frames[1].blobs[1].covariance(0, 0), 0.1 * 0.1) << "a blob without a covariance";
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("line 4"), std::string::npos);
}

TEST(BlobsIo, NamesTheLineAndWhatIsWrong) {
  EXPECT_NE(blobs_error("").find("batten blobs"), std::string::npos);
  EXPECT_NE(blobs_error("{\"batten_session\":1}\n").find("b.jsonl:1:"), std::string::npos);
  EXPECT_NE(blobs_error("{\"format\":\"batten blobs\",\"version\":2}\n").find("newer batten"),
            std::string::npos);
  EXPECT_NE(blobs_error(kHeader + "garbage\n" + kFrame).find("b.jsonl:2:"), std::string::npos);
  EXPECT_NE(blobs_error(kHeader + "{\"time\":1}\n").find("neither a frame"), std::string::npos);
  EXPECT_NE(blobs_error(kHeader + "{\"time\":1,\"camera\":\"top\",\"blobs\":[]}\n").find("left"),
            std::string::npos);
  EXPECT_NE(blobs_error(kHeader + "{\"time\":1,\"camera\":\"left\",\"blobs\":[[1]]}\n").find("[u, v]"),
            std::string::npos);
  EXPECT_NE(blobs_error(kHeader + "{\"time\":1,\"camera\":\"left\",\"blobs\":[[1,2,1,2,1]]}\n")
                .find("not positive"),
            std::string::npos);
  EXPECT_NE(blobs_error(kHeader + "{\"time\":\"x\",\"camera\":\"left\",\"blobs\":[]}\n")
                .find("time must be a number"),
            std::string::npos);
}

TEST(PenPosesIo, ReadsBackAndPassesOverWhatWasLost) {
  const std::vector<TimedPose> poses = {{0, {{1, 2, 3}, {0, -1, 0}}, false},
                                        {0.1, {{1.5, 2, 3}, {0, 0, 1}}, true}};
  const std::string text = format_pen_poses(poses);
  EXPECT_EQ(format_pen_poses(parse_pen_poses(text, "t.csv")), text);
  const auto read = parse_pen_poses(
      "time_s,state,x,y,z,dx,dy,dz,drawing\n0,lost,,,,,,,0\n1,tracked,1,2,3,0,0,2,1\n", "t.csv");
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].pose.direction, Eigen::Vector3d(0, 0, 1));
  EXPECT_THROW(parse_pen_poses("time_s,x,y,z\n", "t.csv"), FileError);
  EXPECT_THROW(parse_pen_poses("time_s,x,y,z,dx,dy,dz,drawing\n0,1,2,3,0,0,0,0\n", "t.csv"), FileError);
  const std::string first = "time_s,x,y,z,dx,dy,dz,drawing\n1,1,2,3,0,0,2,1\n";
  EXPECT_EQ(parse_pen_poses(first + "1,1,2,3,0,0,2,1\n", "t.csv").size(), 2u);
  EXPECT_THROW(parse_pen_poses(first + "0.9,1,2,3,0,0,2,1\n", "t.csv"), FileError) << "time runs backwards";
}

}  // namespace
}  // namespace batten
