#include "batten/pipeline/tracked_pen.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/simulation/pen.hpp"

namespace batten {
namespace {

TEST(TrackedPen, GivesStrokesByEitherMethod) {
  SimulatePenOptions options;
  options.motion.duration = 1;
  const SimulatedPen simulated = simulate_pen(strokes_of(PenPath::Line), options);
  for (const PenMethod method : choice_values<PenMethod>()) {
    TrackedPenOptions tracking;
    tracking.method = method;
    const TrackedPen tracked = tracked_pen(simulated.recording, simulated.nominal, tracking);
    EXPECT_EQ(tracked.strokes.strokes.size(), 1u) << word_of(method);
    EXPECT_TRUE(tracked.warnings.empty()) << word_of(method);
  }
}

TEST(TrackedPen, WarnsOfARigOfOtherCameras) {
  SimulatePenOptions options;
  options.motion.duration = 1;
  const SimulatedPen simulated = simulate_pen(strokes_of(PenPath::Line), options);
  const TrackedPen tracked = tracked_pen(simulated.recording, nominal_rig(PenRig::Vga));
  ASSERT_GE(tracked.warnings.size(), 2u);
  EXPECT_NE(tracked.warnings[0].find("the pen was lost"), std::string::npos);
  EXPECT_NE(tracked.warnings[1].find("1280 x 1024"), std::string::npos);
  TrackedPenOptions bad;
  bad.strokes.spacing = -1;
  EXPECT_THROW(tracked_pen(simulated.recording, simulated.nominal, bad), InvalidInput);
}

}  // namespace
}  // namespace batten
