#include "batten/capture/source.hpp"

#include "capture/simulated.hpp"

#include <algorithm>
#include <deque>

#include <gtest/gtest.h>

#include "batten/capture/morphorider.hpp"
#include "batten/core/error.hpp"

namespace batten::test {
namespace {

TEST(ParseSource, ReadsAllForms) {
  const SourceSpec rider = parse_source("morphorider:/dev/ttyUSB0");
  EXPECT_EQ(rider.kind, SourceSpec::Kind::Morphorider);
  EXPECT_EQ(rider.address, "/dev/ttyUSB0");
  EXPECT_EQ(rider.number, 115200);
  EXPECT_EQ(parse_source("line:/dev/ttyACM1@230400").number, 230400);
  EXPECT_EQ(parse_source("ws://").address, "127.0.0.1");  // this computer alone, unless told otherwise
  EXPECT_EQ(parse_source("ws://0.0.0.0:99/").address, "0.0.0.0");
  EXPECT_EQ(parse_source("ws://0.0.0.0:99/").number, 99);
  EXPECT_EQ(parse_source("udp:9000").address, "127.0.0.1");
  EXPECT_EQ(parse_source("udp:9000").number, 9000);
  EXPECT_EQ(parse_source("udp:0.0.0.0:9000").address, "0.0.0.0");
  EXPECT_EQ(parse_source("file:a?b.blog").address, "a?b.blog");
  const SourceSpec simulator = parse_source("simulator:torus?form=le-tc&tumble");
  EXPECT_EQ(simulator.address, "torus");
  EXPECT_EQ(simulator.options.at("form"), "le-tc");
  EXPECT_EQ(simulator.options.at("tumble"), "1");
}

TEST(ParseSource, RefusesOthersInWords) {
  for (const char* text : {"", "sphere", "serial:/dev/ttyUSB0", "udp:", "udp:70000", "ws://host:0",
                           "line:/dev/ttyUSB0@fast", "morphorider:"})
    EXPECT_THROW(parse_source(text), InvalidInput) << text;
}

TEST(MakeSource, NamesTheOptionThatIsUnknownOrOutOfRange) {
  VirtualClock clock;
  for (const char* text :
       {"simulator:sphere?speeed=2", "simulator:sphere?flip=2", "simulator:cube", "simulator:sphere?unplug=x",
        "line:/dev/null?form=be-sm", "simulator:sphere?form=xx", "simulator:sphere?size=0"})
    EXPECT_THROW(make_source(parse_source(text), clock), InvalidInput) << text;
}

/// A device whose answers are written beforehand: each for one request.
class Script : public ByteStream {
 public:
  Script(std::deque<std::string> answers, VirtualClock& clock)
      : answers_(std::move(answers)), clock_(clock) {}
  void write(std::string_view bytes) override {
    EXPECT_EQ(bytes, "Q");
    if (answers_.empty()) return;
    waiting_ += answers_.front();
    answers_.pop_front();
  }
  std::string read(double seconds) override {
    if (waiting_.empty()) clock_.wait(seconds);
    std::string bytes;
    bytes.swap(waiting_);
    return bytes;
  }

 private:
  std::deque<std::string> answers_;
  VirtualClock& clock_;
  std::string waiting_;
};

// A short answer is followed by a new request, never completed by the bytes of the next.
TEST(MorphoriderSource, NeverPutsAPacketTogetherFromTwo) {
  VirtualClock clock;
  const std::string a(22, 'a'), b(22, 'b');
  const auto source = make_morphorider_source(
      [&] {
        return std::make_unique<Script>(std::deque<std::string>{a, a.substr(0, 15), b, b + "x", b}, clock);
      },
      clock);
  source->open();
  std::vector<CaptureEvent> events;
  EXPECT_THROW(  // silent when it has said all
      for (int i = 0; i < 30; ++i) source->poll(0.05, events);, SourceLost);
  std::vector<std::string> whole;
  for (const CaptureEvent& event : events)
    if (event.payload.size() == 22) whole.push_back(event.payload);
  EXPECT_EQ(whole, (std::vector<std::string>{a, b, b}));
}

TEST(MorphoriderSource, IsLostAfterThreeRequestsWithoutAnswer) {
  VirtualClock clock;
  const auto source = make_morphorider_source(
      [&] { return std::make_unique<Script>(std::deque<std::string>{}, clock); }, clock);
  source->open();
  std::vector<CaptureEvent> events;
  EXPECT_THROW(for (int i = 0; i < 10; ++i) source->poll(0.05, events);, SourceLost);
  EXPECT_LT(clock.now_us(), 400000);
}

TEST(MorphoriderSource, AsksAtMostAHundredTimesASecond) {
  const Captured run = captured("simulator:sphere?speed=max", {.seconds = 3});
  std::int64_t last = -1;
  long n = 0;
  for (const CaptureEvent& event : run.recording.events)
    if (event.kind == EventKind::Packet) {
      if (last >= 0) {
        EXPECT_GE(event.time_us - last, 10000);
      }
      last = event.time_us;
      ++n;
    }
  EXPECT_NEAR(static_cast<double>(n), 300, 2);
}

TEST(ReplaySource, GivesTheEventsOfTheRecordingAsTheyWere) {
  const Captured run = captured("simulator:sphere?speed=max&device=line&fused=1", {.seconds = 4});
  VirtualClock clock;
  const auto source = make_replay_source(run.recording, clock);
  std::vector<CaptureEvent> events;
  capture(*source, clock, run.recording.header, [&](const std::vector<CaptureEvent>& some) {
    events.insert(events.end(), some.begin(), some.end());
  });
  EXPECT_EQ(events, run.recording.events);
}

TEST(ListSources, NamesTheSimulators) {
  const auto sources = list_sources();
  EXPECT_TRUE(std::any_of(sources.begin(), sources.end(),
                          [](const auto& s) { return s.first == "simulator:torus"; }));
  for (const auto& [source, what] : sources) EXPECT_NO_THROW(parse_source(source)) << source;
}

}  // namespace
}  // namespace batten::test
