#include "batten/simulation/pen_motion.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/simulation/pen.hpp"

namespace batten {
namespace {

// The pen keeps its speed along a stroke, and its tremor is as asked for.
TEST(PenMotion, MovesAtItsSpeed) {
  SimulatePenOptions options;
  options.motion.duration = 1;
  options.motion.tremor = 0;
  options.motion.speed = 0.2;
  const SimulatedPen pen = simulate_pen(strokes_of(PenPath::Circle), options);
  double length = 0, time = 0;
  for (std::size_t i = 1; i < pen.truth.size(); ++i) {
    if (!pen.truth[i].drawing || !pen.truth[i - 1].drawing) continue;
    length += (pen.truth[i].pose.tip - pen.truth[i - 1].pose.tip).norm();
    time += pen.truth[i].time - pen.truth[i - 1].time;
  }
  EXPECT_NEAR(length / time, 0.2, 0.01);
}

}  // namespace
}  // namespace batten
