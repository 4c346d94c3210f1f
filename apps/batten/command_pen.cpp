#include "command.hpp"
#include "command_group.hpp"
#include "pen_arguments.hpp"
#include "pen_image_files.hpp"

#include <memory>

#include "batten/capture/pen_pivot.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/pen_io.hpp"

namespace batten::cli {

namespace {

struct PenArguments {
  std::string input, rig, output, tip_offset = "60mm";
};

Outcome run_pen_calibrate(const PenArguments& arguments, const Progress& progress) {
  Outcome outcome;
  const StereoRig rig = rig_named(arguments.rig);
  const BlobRecording recording = read_pen_recording(arguments.input, rig, outcome, progress);
  Pen nominal;
  nominal.tip_offset = metres(arguments.tip_offset);
  PivotCalibration found;
  {
    const ScopedStage stage(outcome.times, "fit");
    try {
      found = calibrate_pivot(recording, rig, nominal);
    } catch (const InvalidInput& error) {
      throw FileError(arguments.input, 0, error.what());
    }
  }
  const ScopedStage stage(outcome.times, "write");
  write_pen({found.pen, found.tip_offset_sigma, found.led_sigma, found.residual}, arguments.output);
  Json& figures = outcome.figures;
  figures["tip_offset_mm"] = 1e3 * found.pen.tip_offset;
  figures["tip_offset_sigma_mm"] = 1e3 * found.tip_offset_sigma;
  figures["leds_mm"] = Json::array();
  figures["led_sigma_mm"] = Json::array();
  for (std::size_t led = 0; led < kPenLeds; ++led) {
    figures["leds_mm"].push_back(1e3 * found.pen.leds[led]);
    figures["led_sigma_mm"].push_back(1e3 * found.led_sigma[led]);
  }
  figures["rms_px"] = found.rms;
  figures["residual_mm"] = 1e3 * found.residual;
  figures["tilt_deg"] = degrees(found.tilt);
  figures["frames"] = found.frames;
  figures["left_out"] = found.left_out;
  figures["output"] = arguments.output;
  outcome.lines = {concat("tip ", 1e3 * found.pen.tip_offset, " mm (± ", 1e3 * found.tip_offset_sigma,
                          ") from the first LED; LEDs at ", 1e3 * found.pen.leds[1], ", ",
                          1e3 * found.pen.leds[2], ", ", 1e3 * found.pen.leds[3], " mm"),
                   concat(found.frames, " frames, blobs within ", found.rms,
                          " pixels, single frames miss the dimple by ", 1e3 * found.residual, " mm"),
                   concat("pen: ", arguments.output)};
  return outcome;
}

}  // namespace

void add_pen(CLI::App& app) {
  CLI::App* group = add_group(app, "pen", "Calibrate a pen with LEDs");
  auto arguments = std::make_shared<PenArguments>();
  CLI::App* command =
      add_command(*group, "calibrate", "Find the tip and the LEDs of a pen that turns about its tip",
                  "batten pen calibrate blobs.jsonl --rig rig.json -o pen.json",
                  [arguments](Context& context) { return run_pen_calibrate(*arguments, context.progress); });
  command
      ->add_option(
          "blobs", arguments->input,
          "The pen with its tip in a dimple, tilted to all sides: blobs (.jsonl), or a folder of images")
      ->required();
  command->add_option("--rig", arguments->rig, "The cameras: a rig file (.json), wiimote, vga or global")
      ->required();
  command->add_option("-o,--output", arguments->output, "The pen (.json)")->required();
  command->add_option("--tip-offset", arguments->tip_offset, "From the tip to the first LED, roughly")
      ->check(metres_text());
}

}  // namespace batten::cli
