#include "batten/pipeline/recorded_capture.hpp"

#include "scratch.hpp"

#include <cstdio>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

RecordedCaptureOptions options_for(const std::string& source, const std::string& name) {
  RecordedCaptureOptions options;
  options.source = source;
  options.recording = scratch_file(name);
  options.overwrite = true;
  return options;
}

bool same_numbers(const Points& a, const Points& b) {
  return a.rows() == b.rows() && ((a.array() == b.array()) || (a.array().isNaN() && b.array().isNaN())).all();
}

// Replaying is decoding again: the log of the replay's own recording is that of the first, bit for bit.
TEST(RecordCapture, OfAReplayGivesTheSameLog) {
  for (const char* device : {"morphorider", "line&fused=1&burst=0.02&ppm=100"}) {
    const auto first = record_capture(options_for(
        std::string("simulator:sphere?speed=max&pace=40&flip=0.2%&seed=9&device=") + device, "first.blog"));
    const auto replayed = replay_recording(read_recording(scratch_file("first.blog")), 0);
    ASSERT_TRUE(first.decoded && replayed.decoded);
    const SensorLog &a = first.decoded->log, &b = replayed.decoded->log;
    EXPECT_GT(a.n_readings(), 1000);
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.curve, b.curve);
    EXPECT_EQ(a.node, b.node);
    EXPECT_TRUE(same_numbers(a.accelerometer, b.accelerometer));
    EXPECT_TRUE(same_numbers(a.magnetometer, b.magnetometer));
    EXPECT_TRUE(same_numbers(a.gyroscope, b.gyroscope));
    EXPECT_EQ(first.report.last.n_readings, replayed.report.last.n_readings);
  }
}

TEST(RecordCapture, StopsByProgressAndKeepsTheRecording) {
  long calls = 0;
  const Progress progress([&calls](std::string_view, double) { return ++calls < 500; });
  long updates = 0;
  CaptureHooks hooks;
  hooks.update = [&updates](const PreviewState&) { ++updates; };
  const auto run = record_capture(options_for("simulator:torus?speed=max", "stopped.blog"), hooks, progress);
  EXPECT_EQ(run.report.end, "stopped");
  EXPECT_GT(updates, 400);
  EXPECT_GT(read_recording(scratch_file("stopped.blog")).events.size(), 400U);
}

TEST(RecordCapture, RefusesBeforeItRecords) {
  EXPECT_THROW(record_capture({}), InvalidInput);
  RecordedCaptureOptions options = options_for("simulator:sphere?speed=max", "never.blog");
  options.wheel_m = -1;
  EXPECT_NE(options.problem()->find("wheel_m"), std::string::npos);
  EXPECT_THROW(record_capture(options), InvalidInput);
  EXPECT_THROW(read_recording(scratch_file("never.blog")), FileError);
  EXPECT_THROW(replay_recording({}, -1), InvalidInput);
}

TEST(RecordCapture, SaysThatTheDiskIsFull) {
  RecordedCaptureOptions options = options_for("simulator:sphere?speed=max", "x");
  options.recording = "/dev/full";
  EXPECT_THROW(record_capture(options), FileError);
}

}  // namespace
}  // namespace batten::test
