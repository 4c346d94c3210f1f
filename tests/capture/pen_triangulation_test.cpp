#include "batten/capture/pen_triangulation.hpp"

#include "capture/judged.hpp"

#include <gtest/gtest.h>

namespace batten::test {
namespace {

TEST(TrackPenByTriangulation, IsWorse) {
  SimulatePenOptions options;
  options.rig = PenRig::Wiimote;
  options.hidden[0] = true;
  const Judged judged = judge(options, 15);
  const PenTrack thesis =
      track_pen_by_triangulation(judged.simulated.recording, judged.simulated.nominal, options.pen);
  const PenAccuracy accuracy =
      pen_accuracy(judged.simulated.recording, thesis, options.pen, judged.simulated.truth);
  EXPECT_GT(accuracy.current.frames, 0.9 * static_cast<double>(judged.track.samples.size()) / 2);
  EXPECT_GT(accuracy.current.mean, 2 * judged.accuracy.lagged.mean);
  EXPECT_LT(accuracy.current.mean, 5e-3) << "and yet no nonsense";
}

}  // namespace
}  // namespace batten::test
