#include "batten/io/wand_io.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

const std::string kHead = R"({"format": "batten blobs", "version": 1}
)";

TEST(ReadWand, PairsFramesOfOneTime) {
  const std::vector<WandFrame> frames = parse_wand(kHead + R"(
{"time": 2.0, "camera": "left", "blobs": [[1, 2, 0.1, 0, 0.1], [3, 4]]}
{"time": 1.0, "camera": "left", "blobs": [[5, 6]]}
{"time": 1.0004, "camera": "right", "blobs": [[7.5, 8]]}
{"time": 0.9, "gyroscope": [0, 0, 1], "accelerometer": [0, 0, 9.8]}
{"time": 1.9995, "camera": "right", "blobs": []}
{"time": 3.0, "camera": "left", "blobs": [[9, 9]]}
{"time": 3.0, "button": "draw", "down": true}
)",
                                                   "blobs.jsonl");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].time, 1.0);
  ASSERT_EQ(frames[0].right.size(), 1U);
  EXPECT_EQ(frames[0].right[0], Eigen::Vector2d(7.5, 8));
  ASSERT_EQ(frames[1].left.size(), 2U);
  EXPECT_EQ(frames[1].left[1], Eigen::Vector2d(3, 4));
  EXPECT_TRUE(frames[1].right.empty());
}

// Each frame of the left camera gets that of the right one which is nearest in time, earlier or later, in
// whatever order the lines are.
TEST(ReadWand, TakesTheFrameNearestInTime) {
  const std::vector<WandFrame> frames = parse_wand(kHead + R"({"time": 2.0, "camera": "left", "blobs": []}
{"time": 2.0006, "camera": "right", "blobs": [[3, 3]]}
{"time": 1.0, "camera": "left", "blobs": []}
{"time": 1.0004, "camera": "right", "blobs": [[2, 2]]}
{"time": 0.9992, "camera": "right", "blobs": [[1, 1]]}
{"time": 1.9995, "camera": "right", "blobs": [[4, 4]]}
)",
                                                   "blobs.jsonl", 0.001);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].right[0], Eigen::Vector2d(2, 2));
  EXPECT_EQ(frames[1].right[0], Eigen::Vector2d(4, 4));
}

TEST(ReadWand, RefusesWithTheLine) {
  const auto said = [](const std::string& text) {
    try {
      parse_wand(text, "blobs.jsonl");
    } catch (const FileError& error) {
      return std::to_string(error.line()) + ": " + error.what();
    }
    return std::string();
  };
  const std::string left = "{\"time\": 1, \"camera\": \"left\", \"blobs\": []}\n";
  EXPECT_NE(said("").find("no frames of the left camera"), std::string::npos);
  EXPECT_NE(said(left).find("no frames of the right camera"), std::string::npos);
  EXPECT_NE(said(left + "{\"time\": 1.1, \"camera\": \"right\", \"blobs\": []}").find("synchronised"),
            std::string::npos);
  EXPECT_EQ(said(left + "{").substr(0, 2), "2:");
  EXPECT_NE(said("[]").find("object"), std::string::npos);
  EXPECT_NE(said("{\"format\": \"batten blobs\", \"version\": 2}").find("newer batten"), std::string::npos);
  EXPECT_NE(said("{\"format\": \"batten rig\"}").find("no file of blobs"), std::string::npos);
  EXPECT_NE(said("{\"camera\": \"left\", \"blobs\": []}").find("time"), std::string::npos);
  EXPECT_NE(said("{\"time\": 1, \"camera\": \"top\", \"blobs\": []}").find("camera"), std::string::npos);
  EXPECT_NE(said("{\"time\": 1, \"camera\": \"left\", \"blobs\": 3}").find("list"), std::string::npos);
  EXPECT_NE(said("{\"time\": 1, \"camera\": \"left\", \"blobs\": [[1]]}").find("[u, v"), std::string::npos);
  EXPECT_NE(said("{\"time\": 1, \"camera\": \"left\", \"blobs\": [[1, \"x\"]]}").find("finite"),
            std::string::npos);
}

}  // namespace
}  // namespace batten::test
