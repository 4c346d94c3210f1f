#include "batten/capture/pseudo_terminal.hpp"

#include "capture/simulated.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "batten/capture/decode.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten::test {
namespace {

// Real time, some seconds each, three times as fast. What is expected holds however late the computer is:
// that what was counted agrees with the truth, not that nothing was missed.
constexpr const char* kShort = "simulator:saddle?speed=3&pace=100&rest=0.4&size=0.2";

long n_states(const Recording& recording, const std::string& begin) {
  long n = 0;
  for (const CaptureEvent& event : recording.events)
    n += event.kind == EventKind::State && event.payload.substr(0, begin.size()) == begin ? 1 : 0;
  return n;
}

TEST(PseudoTerminal, CarriesEachFormOfPackets) {
  for (const char* form : {"be-sm", "be-tc", "le-sm", "le-tc"}) {
    const Captured run = captured(std::string(kShort) + "&form=" + form, {.seconds = 5});
    const DecodedRecording decoded = decode_recording(run.recording);
    ASSERT_TRUE(decoded.report.form.has_value());
    EXPECT_EQ(word_of(decoded.report.form->form), form);
    EXPECT_GT(decoded.log.n_readings(), 10);
    for (Eigen::Index i = 0; i < decoded.log.n_readings(); ++i)
      ASSERT_NEAR(decoded.log.accelerometer.row(i).norm(), 9.81, 0.3);
  }
}

TEST(PseudoTerminal, ComesBackAfterItWasUnplugged) {
  const Captured run = captured(std::string(kShort) + "&unplug=1.5:1.5", {.seconds = 9});
  EXPECT_GE(n_states(run.recording, "lost"), 1);
  EXPECT_GE(n_states(run.recording, "back"), 1);
  EXPECT_GE(run.report.seconds_lost, 1.0);
  const DecodedRecording decoded = decode_recording(run.recording);
  EXPECT_GT(decoded.log.time[decoded.log.n_readings() - 1], 3);
}

TEST(PseudoTerminal, SpeaksTheLineProtocol) {
  const Captured run = captured(std::string(kShort) + "&device=line&fused=1", {.seconds = 5});
  const DecodedRecording decoded = decode_recording(run.recording);
  EXPECT_TRUE(decoded.has_orientations());
  EXPECT_GT(decoded.log.n_readings(), 10);
  EXPECT_TRUE(decoded.log.gyroscope.allFinite());
}

TEST(PseudoTerminal, LeavesNothingBehind) {
  std::string path;
  {
    SteadyClock clock;
    const TracedNetwork traced = trace_shape(AnalyticShape::Sphere);
    SimulateOptions options;
    options.step = 0.05;
    const DeviceMotion motion(simulate_log(traced, simulate_scan(traced, options), DeviceModel(), 0));
    const PseudoTerminal terminal(SimulatedDevice(motion, {}), clock);
    path = terminal.path();
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(path).parent_path()));
}

}  // namespace
}  // namespace batten::test
