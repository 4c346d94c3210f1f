#include "batten/capture/pen_accuracy.hpp"

#include "capture/judged.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

// A frame alone comes within 1.15 of the Cramér–Rao bound; the filter is better than any frame alone, more so
// the more frames it may wait for; and its covariances are true or careful.
TEST(PenAccuracy, WaitingForFramesPays) {
  SimulatePenOptions options;
  options.rig = PenRig::Wiimote;
  const Judged judged = judge(options, 12);
  EXPECT_NEAR(judged.accuracy.single_rms / judged.accuracy.bound_rms, 1, 0.15);
  EXPECT_LT(judged.accuracy.lagged.rms, 0.7 * judged.accuracy.current.rms);
  EXPECT_LT(judged.accuracy.smoothed.rms, 1.01 * judged.accuracy.lagged.rms);
  EXPECT_LT(judged.accuracy.lagged.rms, 0.7 * judged.accuracy.bound_rms);
  EXPECT_GT(judged.accuracy.mean_chi_square, 0.4);
  EXPECT_LT(judged.accuracy.mean_chi_square, 1.5);
}

// Between frames that are 17 ms apart a hand trembles off the line by more than its blobs' errors: the right
// camera's blobs are taken from cubics, or the ratio is 1.5.
TEST(PenAccuracy, FramesOfFreeCamerasReachTheBoundToo) {
  SimulatePenOptions options;
  options.rig = PenRig::Vga;
  options.unsynchronised = true;
  const Judged judged = judge(options, 23);
  EXPECT_GT(judged.accuracy.single_frames, 100);
  EXPECT_NEAR(judged.accuracy.single_rms / judged.accuracy.bound_rms, 1, 0.15);
}

// A track that is the truth moved by 1 mm is off by 1 mm in every frame.
TEST(PenAccuracy, MeasuresAKnownError) {
  Judged judged = judge({}, 18);
  for (TimedPose& pose : judged.simulated.truth) pose.pose.tip.x() += 1e-3;
  const PenAccuracy moved =
      pen_accuracy(judged.simulated.recording, judged.track, {}, judged.simulated.truth);
  EXPECT_NEAR(moved.lagged.mean, 1e-3, 5e-5);
  EXPECT_NEAR(moved.lagged.below_2mm, 1, 1e-9);
  judged.simulated.truth.resize(1);
  EXPECT_THROW(pen_accuracy(judged.simulated.recording, judged.track, {}, judged.simulated.truth),
               InvalidInput);
}

}  // namespace
}  // namespace batten::test
