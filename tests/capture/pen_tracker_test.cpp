#include "batten/capture/pen_tracker.hpp"

#include "capture/judged.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

// The targets of the pen at 30 ms of lag, in millimetres: mean and 95 % (docs/pen.md).
TEST(TrackPen, KeepsItsTargetsOnEveryRig) {
  const struct {
    PenRig rig;
    double distance;
    bool tip_hidden;
    double mean, p95;
  } cases[] = {{PenRig::Wiimote, 0.45, false, 0.45, 1.0}, {PenRig::Wiimote, 0.8, false, 1.2, 2.8},
               {PenRig::Vga, 0.8, false, 0.4, 1.0},       {PenRig::Vga, 0.8, true, 0.5, 1.3},
               {PenRig::Global, 0.45, false, 0.2, 0.5},   {PenRig::Global, 0.45, true, 0.3, 0.7},
               {PenRig::Global, 0.8, false, 0.4, 1.0}};
  for (const auto& c : cases) {
    SimulatePenOptions options;
    options.rig = c.rig;
    options.motion.distance = c.distance;
    options.hidden[0] = c.tip_hidden;
    options.rotation_error = radians(0.02);
    options.focal_error = 1e-3;
    const Judged judged = judge(options, 11);
    EXPECT_LT(1e3 * judged.accuracy.lagged.mean, c.mean) << word_of(c.rig) << " at " << c.distance;
    EXPECT_LT(1e3 * judged.accuracy.lagged.p95, c.p95) << word_of(c.rig) << " at " << c.distance;
    EXPECT_EQ(judged.accuracy.wrong_identities, 0) << word_of(c.rig) << " at " << c.distance;
    EXPECT_GT(judged.accuracy.answered, 0.99 * static_cast<double>(judged.accuracy.answerable));
  }
}

// The right camera is turned by 0.05 degrees and its focal length 0.2 % off: both are found.
TEST(TrackPen, CorrectsTheRigWhileItTracks) {
  SimulatePenOptions options;
  options.rotation_error = radians(0.05);
  options.focal_error = 2e-3;
  const Judged judged = judge(options, 13);
  const Eigen::Matrix3d left = judged.track.rig.rotation * judged.simulated.actual.rotation.transpose();
  EXPECT_LT(Eigen::AngleAxisd(left).angle(), 0.1 * options.rotation_error);
  EXPECT_NEAR(judged.track.rig.right.fx / judged.simulated.actual.right.fx, 1, 1e-4);
  TrackOptions trusting;
  trusting.rotation_sigma = trusting.focal_sigma = 0;
  // Held to be exact, such a rig contradicts the blobs.
  EXPECT_LT(judge(options, 13, PenPath::Circle, trusting).accuracy.answered, judged.accuracy.answered / 2);
}

// While a hand covers LEDs the pen is tracked by what is left, or lost with a reason; it is never elsewhere.
TEST(TrackPen, LosesThePenRatherThanGuess) {
  for (const PenRig rig : {PenRig::Vga, PenRig::Global}) {
    SimulatePenOptions options;
    options.rig = rig;
    options.hand = 1;
    options.false_blobs = 2;
    const Judged judged = judge(options, 14, PenPath::Spiral);
    EXPECT_EQ(judged.accuracy.wrong_identities, 0);
    EXPECT_LT(judged.accuracy.lagged.p95, 5e-3);
    long lost = 0;
    for (const PenSample& sample : judged.track.samples) {
      if (sample.state != PenState::Lost) continue;
      ++lost;
      EXPECT_FALSE(sample.reason.empty());
    }
    EXPECT_EQ(lost, judged.track.report.lost);
  }
}

// Once the pen is found, answers come no later than the lag says.
TEST(PenTracker, AnswersWithinItsLag) {
  SimulatePenOptions options;
  options.motion.seed = 17;
  options.motion.duration = 1;
  const SimulatedPen simulated = simulate_pen(strokes_of(PenPath::Line), options);
  PenTracker tracker(simulated.nominal, options.pen);
  for (const BlobFrame& frame : simulated.recording.frames) {
    tracker.push(frame);
    if (frame.time < 0.1) continue;  // found and confirmed by then
    for (const PenSample& sample : tracker.samples()) {
      if (sample.time < 0.02 || sample.time > frame.time - TrackOptions().lag) continue;
      ASSERT_EQ(sample.state, PenState::Tracked) << sample.time << " at " << frame.time;
    }
  }
  EXPECT_THROW(tracker.push({0.5, CameraSide::Left, {}}), InvalidInput);
}

TEST(TrackPen, RefusesRecordingsOfOneCamera) {
  BlobRecording recording;
  recording.frames.push_back({0, CameraSide::Left, {}});
  EXPECT_THROW(track_pen(recording, nominal_rig(PenRig::Vga), {}), InvalidInput);
  recording.frames.push_back({0, CameraSide::Right, {}});
  const PenTrack track = track_pen(recording, nominal_rig(PenRig::Vga), {});
  EXPECT_EQ(track.report.lost, 2) << "frames without a blob";
  EXPECT_THROW(track_pen(recording, nominal_rig(PenRig::Vga), {}, {.lag = -1}), InvalidInput);
}

}  // namespace
}  // namespace batten::test
