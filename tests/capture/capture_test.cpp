#include "batten/capture/capture.hpp"

#include "capture/simulated.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

long count(const Recording& recording, EventKind kind, const std::string& begin = {}) {
  long n = 0;
  for (const CaptureEvent& event : recording.events)
    n += event.kind == kind && event.payload.substr(0, begin.size()) == begin ? 1 : 0;
  return n;
}

TEST(Capture, MarksALossAndGoesOn) {
  const Captured run = captured("simulator:sphere?speed=max&unplug=3:5", {.seconds = 15});
  EXPECT_EQ(run.report.n_losses, 1);
  EXPECT_EQ(count(run.recording, EventKind::State, "lost"), 1);
  EXPECT_EQ(count(run.recording, EventKind::State, "back"), 1);
  EXPECT_NEAR(run.report.seconds_lost, 5, 0.6);  // and up to half a second until the next attempt
  EXPECT_NEAR(static_cast<double>(count(run.recording, EventKind::Packet)), 1000, 60);
}

TEST(Capture, ToleratesSilenceInTheSameWay) {
  for (const char* device : {"morphorider", "line"}) {
    const Captured run =
        captured(std::string("simulator:sphere?speed=max&silence=3:8&device=") + device, {.seconds = 15});
    EXPECT_EQ(run.report.n_losses, 1) << device;
    EXPECT_EQ(count(run.recording, EventKind::State, "back"), 1) << device;
  }
}

TEST(Capture, GivesUpOnADeviceThatNeverAnswers) {
  try {
    captured("simulator:sphere?speed=max&silence=0:1000");
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("silent"), std::string::npos);
  }
}

// What a wrong baud rate makes of lines.
class Babbler : public Source {
 public:
  explicit Babbler(HostClock& clock) : clock_(clock) {}
  void open() override {}
  void poll(double seconds, std::vector<CaptureEvent>& events) override {
    clock_.wait(seconds);
    events.push_back({clock_.now_us(), "device", EventKind::Line, "\xf3\x80\x1f~~"});
  }
  void close() override {}
  SourceState state() const override { return {SourceState::Kind::Open, {}}; }

 private:
  HostClock& clock_;
};

TEST(Capture, TellsBabbleFromLinesAndKeepsIt) {
  VirtualClock clock;
  Babbler source(clock);
  long n = 0;
  try {
    capture(source, clock, {},
            [&n](const std::vector<CaptureEvent>& events) { n += static_cast<long>(events.size()); });
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("baud"), std::string::npos);
  }
  EXPECT_GT(n, 90);
}

TEST(Capture, RecordsKeysAndEndsByQ) {
  int calls = 0;
  CaptureHooks hooks;
  hooks.keys = [&calls]() -> std::vector<std::string> {
    ++calls;
    if (calls == 10) return {"+", "7"};
    if (calls == 50) return {"q"};
    return {};
  };
  const Captured run = captured("simulator:sphere?speed=max", {}, hooks);
  EXPECT_EQ(run.report.end, "ended by q");
  EXPECT_EQ(calls, 50);
  EXPECT_EQ(count(run.recording, EventKind::Key, "7"), 1);
}

TEST(Capture, KeepsWhatCameBeforeTheDiskWasFull) {
  const SourceSpec spec = parse_source("simulator:sphere?speed=max");
  const auto clock = make_clock(spec);
  const auto source = make_source(spec, *clock);
  long n = 0;
  const auto record = [&n](const std::vector<CaptureEvent>& events) {
    n += static_cast<long>(events.size());
    if (n > 100) throw InvalidInput("the disk is full");
  };
  EXPECT_THROW(capture(*source, *clock, {}, record), InvalidInput);
  EXPECT_GT(n, 100);
}

TEST(CaptureOptions, SayWhatIsWrong) {
  VirtualClock clock;
  Babbler source(clock);
  EXPECT_THROW(capture(source, clock, {}, {}, {.seconds = -1}), InvalidInput);
  EXPECT_NE(CaptureOptions{.reopen_s = 0}.problem()->find("reopen_s"), std::string::npos);
}

}  // namespace
}  // namespace batten::test
