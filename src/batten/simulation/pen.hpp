#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "batten/camera/blobs.hpp"
#include "batten/core/choices.hpp"
#include "batten/simulation/pen_images.hpp"
#include "batten/simulation/pen_motion.hpp"
#include "batten/simulation/spot.hpp"

namespace batten {

/// Pairs of cameras, 0.25 m apart, whose axes meet at 0.6 m.
enum class PenRig {
  Wiimote,  ///< 128 × 96, 45°, 100 Hz, clocks of their own; four blobs at most, centres in steps of 1/8 pixel
  Vga,      ///< 640 × 480, 45°, 60 Hz
  Global,  ///< 1280 × 1024 with a global shutter, 60°, 120 Hz
};

constexpr auto choices_of(PenRig) {
  return choices<PenRig>("rig",
                         {{PenRig::Wiimote, "wiimote"}, {PenRig::Vga, "vga"}, {PenRig::Global, "global"}});
}

/// The cameras of such a pair as their maker means them to be: no lens distortion.
StereoRig nominal_rig(PenRig kind);

/// What simulated cameras see of a pen, and what disturbs them.
struct SimulatePenOptions {
  PenRig rig = PenRig::Global;
  PenMotionOptions motion;  ///< its seed is that of everything
  Pen pen;
  std::array<bool, kPenLeds> hidden = {};  ///< LEDs that neither camera ever sees
  /// A hand covers one to three LEDs, both cameras alike, for 0.1 s to this many seconds, every second or so;
  /// 0: never.
  double hand = 0;
  int false_blobs = 0;  ///< in each camera: mirrored LEDs and lamps by turns, 0 to 20
  bool sun = false;     ///< large spots of some seconds, in one camera or both
  /// The cameras run freely: their phases are random and their rates differ by 50 ppm. Wiimotes always do.
  bool unsynchronised = false;
  /// By how much the right camera is off the nominal rig: its turn about a random axis, radians, and its
  /// focal lengths, as a fraction, up or down.
  double rotation_error = 0, focal_error = 0;
  bool inertial = false;  ///< readings of a gyroscope and an accelerometer in the pen, 200 Hz
  bool images = false;    ///< what pen_image() needs to draw each frame

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A simulated recording with its truth.
struct SimulatedPen {
  BlobRecording recording;
  std::vector<TimedPose> truth;  ///< every 2 ms
  StereoRig nominal;             ///< what the user believes
  StereoRig actual;              ///< what took the images
  long images_of_leds = 0;       ///< that were seen, over all frames
  /// For every frame what is bright in it, where images are wanted: LEDs and mirrored ones, lamps of 15 mm
  /// radius with a streak of glare, the sun. What is hidden is not there.
  std::vector<std::vector<SeenLight>> lights;
};

/// Frames of both cameras: the LEDs that are inside the image and not hidden, each averaged over the
/// exposure, with normal errors of the covariance given in the frame (for Wiimotes: 0.075 pixels and rounding
/// to 1/8; for others the Cramér–Rao bound of centre_bound() on an image of light ∝ 1/z² and cos of the angle
/// off the LED's axis), and what else is bright, in random order. Each effect draws from its own stream.
/// @throws InvalidInput on bad options.
SimulatedPen simulate_pen(const std::vector<Points>& strokes, const SimulatePenOptions& options);

}  // namespace batten
