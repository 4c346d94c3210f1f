#include "batten/capture/pen_strokes.hpp"

#include "capture/judged.hpp"

#include <gtest/gtest.h>

namespace batten::test {
namespace {

// Strokes end with the button; a circle drawn comes back as one.
TEST(StrokesOfTrack, CutsStrokesWhereTheButtonGoesUp) {
  SimulatePenOptions options;
  const Judged judged = judge(options, 16, PenPath::Circle);
  const PenStrokes strokes = strokes_of_track(judged.track.samples, judged.simulated.recording.buttons);
  ASSERT_EQ(strokes.strokes.size(), judged.simulated.recording.buttons.size() / 2);
  for (const PenStroke& stroke : strokes.strokes) {
    const Eigen::RowVector3d centre = stroke.points.colwise().mean();
    for (Eigen::Index i = 0; i < stroke.points.rows(); ++i)
      EXPECT_NEAR((stroke.points.row(i) - centre).norm(), 0.04, 2e-3);
    for (Eigen::Index i = 1; i + 1 < stroke.points.rows(); ++i)
      EXPECT_GE((stroke.points.row(i) - stroke.points.row(i - 1)).norm(), 1e-3 - 1e-12);
    EXPECT_LT(stroke.sigma.maxCoeff(), 1e-4);
  }
}

}  // namespace
}  // namespace batten::test
