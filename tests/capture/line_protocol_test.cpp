#include "batten/capture/line_protocol.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

// The check by hand: 'E' ^ ',' ^ 'x' = 0x45 ^ 0x2c ^ 0x78 = 0x11.
TEST(LineCheck, IsTheExclusiveOrOfAllBytes) {
  EXPECT_EQ(line_check("E,x"), 0x11U);
  EXPECT_EQ(std::get<DeviceComplaint>(parse_line("E,x*11")).text, "x");
  EXPECT_THROW(parse_line("E,x*12"), InvalidInput);
}

TEST(ParseLine, ReadsBackWhatWasWritten) {
  RawSample raw;
  raw.seq = 4294967295U;
  raw.t_us = 17;
  raw.ticks = -2147483648;
  raw.accelerometer = {0.5, -9.75, 1e-3};
  raw.gyroscope.setConstant(std::nan(""));
  raw.magnetometer = {20, 0, -43};
  const auto read = std::get<RawSample>(parse_line(format_line(raw)));
  EXPECT_EQ(read.seq, raw.seq);
  EXPECT_EQ(read.t_us, raw.t_us);
  EXPECT_EQ(read.ticks, raw.ticks);
  EXPECT_EQ(read.accelerometer, raw.accelerometer);
  EXPECT_TRUE(read.gyroscope.array().isNaN().all());
  EXPECT_EQ(read.magnetometer, raw.magnetometer);
}

TEST(ParseLine, QuaternionsAreBroughtToLengthOne) {
  const auto q = std::get<FusedSample>(parse_line("Q,1,2,,0.71,0,0,0.71,", false));
  EXPECT_NEAR(q.orientation.norm(), 1, 1e-15);
  EXPECT_FALSE(q.ticks.has_value());
  EXPECT_TRUE(std::isnan(q.accuracy_rad));
  EXPECT_NEAR((q.orientation * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 1, 0)).norm(), 0, 1e-12);
}

TEST(ParseLine, ReadsAHeaderAndWritesItBack) {
  const std::string line =
      "#batten 1 device=rider axes=-y,+z ticks_per_m=20000 rate_hz=100 wheel_offset_m=0.01 quat=wxyz";
  const auto header = std::get<DeviceHeader>(parse_line(line));
  EXPECT_EQ(header.device, "rider");
  EXPECT_EQ(header.axes->forward, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(header.axes->normal, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(header.ticks_per_m, 20000);
  EXPECT_TRUE(header.checked);
  EXPECT_EQ(format_line(header), line);
  EXPECT_FALSE(std::get<DeviceHeader>(parse_line("#batten 1 check=none")).checked);
}

TEST(ParseLine, RefusesInWords) {
  for (const char* line :
       {"", "X,1,2", "S,1,2,3", "K,1,2,end me", "K,1,2,", "Q,1,2,3,9,0,0,0,0", "S,4294967296,2,3,,,,,,,,,",
        "S,1,2,2147483648,,,,,,,,,", "S,1,2,3,1e9,,,,,,,,", "S,1,2,3,nan,0,0,,,,,,", "#batten 2",
        "#batten 1 axes=+x,-x", "#batten 1 quat=xyzw", "#other"})
    EXPECT_THROW(parse_line(line, false), InvalidInput) << line;
  EXPECT_THROW(parse_line("K,1,2,end", true), InvalidInput);  // without a check
  EXPECT_NO_THROW(parse_line("K,1,2,end", false));
  EXPECT_THROW(parse_line("E," + std::string(199, 'x'), false), InvalidInput);  // 201 characters
}

TEST(LineSplitter, GivesTheSameLinesHoweverTheBytesCome) {
  const std::string text = "one\r\ntwo\n\nthree\n" + std::string(450, 'x') + "\nend";
  LineSplitter whole, single;
  std::vector<std::string> lines;
  for (const char c : text)
    for (const std::string& line : single.push(std::string(1, c))) lines.push_back(line);
  EXPECT_EQ(whole.push(text), lines);
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(lines[0], "one");
  EXPECT_EQ(lines[3].size(), kLongestLine);
  EXPECT_EQ(lines[5].size(), 50U);
}

}  // namespace
}  // namespace batten::test
