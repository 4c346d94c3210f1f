#include "batten/simulation/pen.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

SimulatePenOptions short_run(PenRig rig) {
  SimulatePenOptions options;
  options.rig = rig;
  options.motion.duration = 1;
  return options;
}

// The mean of many images of an LED is its projection, and their spread what the frames say.
TEST(SimulatePen, BlobsLieRoundTheImagesOfLeds) {
  for (const PenRig kind : {PenRig::Wiimote, PenRig::Vga, PenRig::Global}) {
    const SimulatePenOptions options = short_run(kind);
    const SimulatedPen pen = simulate_pen(strokes_of(PenPath::Circle), options);
    double chi_square = 0, n = 0;
    for (const BlobFrame& frame : pen.recording.frames) {
      const auto i = static_cast<std::size_t>(frame.time / 2e-3);
      const double w = frame.time / 2e-3 - static_cast<double>(i);
      for (const Blob& blob : frame.blobs) {
        double nearest = 1e9;
        for (int led = 0; led < kPenLeds; ++led) {
          const Eigen::Vector3d point = (1 - w) * led_position(options.pen, pen.truth[i].pose, led) +
                                        w * led_position(options.pen, pen.truth[i + 1].pose, led);
          const Eigen::Vector2d off = blob.pixel - *image_in(pen.actual, frame.camera, point);
          nearest = std::min(nearest, off.squaredNorm() / (blob.covariance.trace() / 2));
        }
        chi_square += nearest / 2;
        ++n;
      }
    }
    EXPECT_GT(n, 0.9 * 8 * static_cast<double>(pen.recording.frames.size()) / 2) << word_of(kind);
    EXPECT_NEAR(chi_square / n, 1, 0.1) << word_of(kind);
  }
}

TEST(SimulatePen, DependsOnItsSeedAlone) {
  SimulatePenOptions options = short_run(PenRig::Vga);
  const SimulatedPen first = simulate_pen(strokes_of(PenPath::Line), options);
  options.sun = true;  // draws from a stream of its own
  const SimulatedPen second = simulate_pen(strokes_of(PenPath::Line), options);
  ASSERT_EQ(first.truth.size(), second.truth.size());
  EXPECT_EQ(first.truth[100].pose.tip, second.truth[100].pose.tip);
  EXPECT_EQ(first.images_of_leds, second.images_of_leds);
  options.motion.seed = 1;
  EXPECT_NE(simulate_pen(strokes_of(PenPath::Line), options).truth[100].pose.tip, first.truth[100].pose.tip);
}

TEST(SimulatePen, HidesWhatIsHidden) {
  SimulatePenOptions options = short_run(PenRig::Global);
  options.hidden = {true, false, true, false};
  for (const BlobFrame& frame : simulate_pen(strokes_of(PenPath::Spiral), options).recording.frames)
    EXPECT_LE(frame.blobs.size(), 2u);
  options.false_blobs = 2;
  options.rig = PenRig::Wiimote;
  for (const BlobFrame& frame : simulate_pen(strokes_of(PenPath::Spiral), options).recording.frames)
    EXPECT_LE(frame.blobs.size(), 4u) << "more than a Wiimote reports";
}

TEST(SimulatePen, RefusesWhatItCannotDo) {
  SimulatePenOptions options;
  options.motion.distance = 0;
  EXPECT_THROW(simulate_pen(strokes_of(PenPath::Line), options), InvalidInput);
  options = {};
  options.false_blobs = -1;
  EXPECT_THROW(simulate_pen(strokes_of(PenPath::Line), options), InvalidInput);
  EXPECT_THROW(simulate_pen({}, SimulatePenOptions()), InvalidInput);
}

}  // namespace
}  // namespace batten
