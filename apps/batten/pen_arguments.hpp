#pragma once
#include "command.hpp"

#include <string>

#include "batten/camera/rig.hpp"
#include "batten/core/arrays.hpp"
#include "batten/simulation/pen.hpp"

namespace batten::cli {

/// The options of `batten simulate pen`.
struct SimulatePenArguments {
  std::string rig = "global", path = "circle", distance = "0.6m", tip_offset = "60mm", hide, hand = "0",
              calibration_error = "0", rig_output, images, corners, duration, tremor = "0.1mm";
  double speed = PenMotionOptions().speed;
  int false_blobs = 0;
  bool sun = false, unsynchronised = false, imu = false;
};

/// Adds them to `simulate`.
void add_simulate_pen_options(CLI::App& command, SimulatePenArguments& arguments);

/// Carries `simulate pen` out.
Outcome run_simulate_pen(const SimulatePenArguments& arguments, const std::string& output,
                         const std::string& truth, std::uint64_t seed, const Progress& progress);

/// A plain length in metres, "60mm" or "0.06". @throws InvalidInput, also on a share of the diameter.
double metres(const std::string& text);
/// "0.5s", "200ms" or "0.5". @return seconds. @throws InvalidInput.
double seconds(const std::string& text);
CLI::Validator metres_text();
CLI::Validator time_text();

/// The nominal cameras of that name (wiimote, vga, global), else the rig of a file. @throws FileError.
StereoRig rig_named(const std::string& name);

}  // namespace batten::cli
