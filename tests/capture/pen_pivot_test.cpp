#include "batten/capture/pen_pivot.hpp"

#include "capture/pens.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

SimulatedPen pivoting(std::uint64_t seed, const Pen& pen, PenRig rig = PenRig::Global) {
  SimulatePenOptions options;
  options.rig = rig;
  options.pen = pen;
  options.motion.seed = seed;
  options.motion.pivot = true;
  options.motion.duration = 3;
  return simulate_pen({}, options);
}

std::string refusal(const BlobRecording& recording, const PivotOptions& options = {}) {
  try {
    calibrate_pivot(recording, nominal_rig(PenRig::Global), {}, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return {};
}

// A pen whose tip is 15 mm and whose LEDs are some tenths of a millimetre off what its maker says: both are
// found, to within what the calibration itself says of its errors (χ² of four numbers over four seeds).
TEST(CalibratePivot, FindsTipAndLeds) {
  Pen actual;
  actual.tip_offset = 0.075;
  actual.leds = {0, 0.0703, 0.1098, 0.1602};
  double chi_square = 0;
  const int n = 4;
  for (int seed = 1; seed <= n; ++seed) {
    const SimulatedPen simulated = pivoting(static_cast<std::uint64_t>(seed), actual);
    const PivotCalibration found = calibrate_pivot(simulated.recording, simulated.actual, {});
    EXPECT_NEAR(found.pen.tip_offset, actual.tip_offset, 5e-5);
    chi_square += std::pow((found.pen.tip_offset - actual.tip_offset) / found.tip_offset_sigma, 2) / (4 * n);
    for (std::size_t led = 1; led < kPenLeds; ++led) {
      EXPECT_NEAR(found.pen.leds[led], actual.leds[led], 5e-5);
      chi_square += std::pow((found.pen.leds[led] - actual.leds[led]) / found.led_sigma[led], 2) / (4 * n);
    }
    EXPECT_LT((found.tip - simulated.truth.front().pose.tip).norm(), 1e-4);
    EXPECT_LT(found.rms, 0.05);
  }
  EXPECT_GT(chi_square, 0.3);
  EXPECT_LT(chi_square, 2.5);
}

TEST(CalibratePivot, RefusesInWords) {
  Pen pen;
  SimulatePenOptions drawing;
  drawing.motion.duration = 3;
  const std::string moved = refusal(simulate_pen(strokes_of(PenPath::Line), drawing).recording);
  EXPECT_TRUE(moved.find("dimple") != std::string::npos || moved.find("at rest") != std::string::npos)
      << moved;
  const SimulatedPen simulated = pivoting(1, pen);
  EXPECT_NE(refusal(simulated.recording, {.least_tilt = 3}).find("tilt it by 40 degrees"), std::string::npos);
  EXPECT_NE(refusal(simulated.recording, {.least_frames = 100000}).find("some seconds"), std::string::npos);
  EXPECT_NE(refusal(simulated.recording, {.outliers = 0}).find("outliers"), std::string::npos);
}

}  // namespace
}  // namespace batten::test
