#include "device/batten_protocol.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "batten/capture/decode.hpp"
#include "batten/capture/line_protocol.hpp"

namespace batten::test {
namespace {

namespace dev = batten_device;

std::string text_of(const dev::Line& line) {
  std::string text(line.text(), line.length());
  EXPECT_EQ(text.back(), '\n');
  text.pop_back();
  return text;
}

// The device's writer and our reader were written apart from each other.
TEST(DeviceExample, SpeaksWithTheReaderOfTheHost) {
  dev::Line line;
  const float acc[3] = {-0.0004F, 9.8067F, -19.9996F}, gyr[3] = {NAN, NAN, NAN},
              mag[3] = {24.005F, -0.5F, 1e7F};
  dev::write_raw(line, 4294967295U, 123, -2147483647 - 1, acc, gyr, mag);
  const auto raw = std::get<RawSample>(parse_line(text_of(line)));
  EXPECT_EQ(raw.seq, 4294967295U);
  EXPECT_EQ(raw.ticks, -2147483647 - 1);
  EXPECT_NEAR((raw.accelerometer - Eigen::Vector3d(0, 9.807, -20)).norm(), 0, 1e-6);
  EXPECT_TRUE(raw.gyroscope.array().isNaN().all());
  EXPECT_TRUE(raw.magnetometer.array().isNaN().all());  // 1e7 µT is none

  const float q[4] = {0.70711F, 0, -0.70711F, 0};
  dev::write_fused(line, 7, 8, 9, q, NAN);
  const auto fused = std::get<FusedSample>(parse_line(text_of(line)));
  EXPECT_NEAR(fused.orientation.y(), -std::sqrt(0.5), 1e-5);
  EXPECT_TRUE(std::isnan(fused.accuracy_rad));

  dev::write_key(line, 1, 2, "node");
  EXPECT_EQ(std::get<ButtonPress>(parse_line(text_of(line))).key, "node");
  dev::write_header(line, {"mine", "-y,+z", 20000, 100});
  const auto header = std::get<DeviceHeader>(parse_line(text_of(line)));
  EXPECT_EQ(header.device, "mine");
  EXPECT_EQ(header.ticks_per_m, 20000);
  EXPECT_EQ(header.axes->forward, Eigen::Vector3d(0, -1, 0));
}

TEST(DeviceExample, ItsLongestLineKeepsTheLimit) {
  dev::Line line;
  const float most[3] = {-999999.0F, -999999.0F, -999999.0F};
  dev::write_raw(line, 4294967295U, 4294967295U, -2147483647 - 1, most, most, most);
  EXPECT_LE(line.length(), kLongestLine + 1);
  EXPECT_NO_THROW(parse_line(text_of(line)));
}

TEST(DeviceExample, UnderstandsTheHost) {
  dev::Commands commands;
  std::vector<dev::Command> got;
  for (const char c : std::string("?\nstart\r\nled 1\nnonsense that is too long for it\nstop\n"))
    if (const dev::Command command = commands.take(c); command != dev::Command::kNone) got.push_back(command);
  EXPECT_EQ(got, (std::vector<dev::Command>{dev::Command::kHeader, dev::Command::kStart, dev::Command::kLedOn,
                                            dev::Command::kStop}));
}

// A turn through all four states of both lines is four counts, the other way round minus four.
TEST(DeviceExample, CountsQuadrature) {
  dev::Quadrature wheel;
  int count = 0;
  const bool states[4][2] = {{true, false}, {true, true}, {false, true}, {false, false}};
  for (int turn = 0; turn < 3; ++turn)
    for (const auto& s : states) count += wheel.update(s[0], s[1]);
  EXPECT_EQ(count, 12);
  for (int k = 3; k-- > 0;) count += wheel.update(states[k][0], states[k][1]);
  EXPECT_EQ(count, 9);
}

TEST(DeviceExample, TellsShortPressesFromLongOnesAndFromBouncing) {
  dev::Button button;
  int n_short = 0, n_long = 0;
  const auto hold = [&](bool down, std::uint32_t from_ms, std::uint32_t to_ms) {
    for (std::uint32_t ms = from_ms; ms < to_ms; ++ms) {
      const dev::Button::Press press = button.update(down, 1000 * ms);
      n_short += press == dev::Button::Press::kShort ? 1 : 0;
      n_long += press == dev::Button::Press::kLong ? 1 : 0;
    }
  };
  for (std::uint32_t ms = 100; ms < 110; ++ms) hold(ms % 2 == 0, ms, ms + 1);
  hold(true, 110, 300);
  hold(false, 300, 400);
  EXPECT_EQ(n_short, 1);
  hold(true, 400, 1400);
  hold(false, 1400, 1500);
  EXPECT_EQ(n_long, 1);
  EXPECT_EQ(n_short, 1);
}

}  // namespace
}  // namespace batten::test
