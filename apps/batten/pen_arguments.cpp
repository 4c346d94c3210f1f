#include "pen_arguments.hpp"

#include "pen_image_files.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/blobs_io.hpp"
#include "batten/io/file.hpp"
#include "batten/io/rig_io.hpp"
#include "batten/session/journal.hpp"
#include "batten/simulation/simulate_boards.hpp"

namespace batten::cli {

namespace {

constexpr const char* kPivot = "pivot";

std::array<bool, kPenLeds> hidden_leds(const std::string& text) {
  std::array<bool, kPenLeds> hidden{};
  if (trim(text).empty()) return hidden;
  for (const std::string_view word : split_fields(text, ',')) {
    long led = 0;
    if (word == "tip")
      led = 1;
    else if (!parse_integer(word, led) || led < 1 || led > kPenLeds)
      throw InvalidInput(concat("'", word, "' is no LED; write tip or 1 to 4, such as tip,3"));
    hidden[static_cast<std::size_t>(led - 1)] = true;
  }
  return hidden;
}

/// "0.02deg,0.1%": the turn of the right camera and its focal length.
void read_calibration_error(const std::string& text, SimulatePenOptions& options) {
  const std::vector<std::string_view> parts = split_fields(text, ',');
  if (parts.size() > 2) throw InvalidInput(concat("'", text, "' has more than an angle and a share"));
  options.rotation_error = parse_angle(parts[0]);
  if (parts.size() == 2) options.focal_error = parse_fraction(parts[1]);
}

/// The strokes that a session inserts.
std::vector<Points> strokes_of_session(const std::string& path) {
  std::vector<Points> strokes;
  for (const SessionEdit& edit : read_session(path).edits) {
    const ModelEdit* model = std::get_if<ModelEdit>(&edit.edit);
    const InsertEdit* insert = model ? std::get_if<InsertEdit>(&model->edit) : nullptr;
    if (insert && insert->stroke.points.rows() >= 2) strokes.push_back(insert->stroke.points);
  }
  if (strokes.empty()) throw FileError(path, 0, "the session draws no stroke");
  return strokes;
}

SimulatePenOptions options_of(const SimulatePenArguments& arguments, std::uint64_t seed) {
  SimulatePenOptions options;
  options.rig = parse_choice<PenRig>(arguments.rig);
  options.motion.seed = seed;
  options.motion.distance = metres(arguments.distance);
  options.motion.speed = arguments.speed;
  options.motion.tremor = metres(arguments.tremor);
  if (!arguments.duration.empty()) options.motion.duration = seconds(arguments.duration);
  options.pen.tip_offset = metres(arguments.tip_offset);
  options.hidden = hidden_leds(arguments.hide);
  options.hand = seconds(arguments.hand);
  options.false_blobs = arguments.false_blobs;
  options.sun = arguments.sun;
  options.unsynchronised = arguments.unsynchronised;
  options.inertial = arguments.imu;
  options.images = !arguments.images.empty();
  read_calibration_error(arguments.calibration_error, options);
  return options;
}

}  // namespace

double metres(const std::string& text) {
  const Length length = parse_length(text);
  if (length.kind == Length::Kind::Relative)
    throw InvalidInput(concat("'", text, "' is a share of a diameter; write a length such as 60mm or 0.06"));
  return length.value;
}

double seconds(const std::string& text) {
  std::string_view number = trim(text);
  double factor = 1;
  if (number.size() > 2 && number.substr(number.size() - 2) == "ms") {
    factor = 1e-3;
    number.remove_suffix(2);
  } else if (number.size() > 1 && number.back() == 's') {
    number.remove_suffix(1);
  }
  double value = 0;
  if (!parse_number(trim(number), value) || !std::isfinite(value))
    throw InvalidInput(concat("'", text, "' is no time; write 1s, 200ms or 0.2"));
  return factor * value;
}

CLI::Validator time_text() {
  return parses("TIME", [](const std::string& text) { seconds(text); });
}

CLI::Validator metres_text() {
  return parses("LENGTH", [](const std::string& text) { metres(text); });
}

StereoRig rig_named(const std::string& name) {
  if (const auto kind = choices_of(PenRig{}).find(name)) return nominal_rig(*kind);
  return read_rig(name).rig;
}

void add_simulate_pen_options(CLI::App& command, SimulatePenArguments& a) {
  const auto group = [](CLI::Option* option) { return option->group("Simulate a pen"); };
  group(command.add_option("--rig", a.rig, "Cameras: wiimote, vga or global")
            ->check(CLI::IsMember(choice_words<PenRig>())));
  group(command.add_option("--path", a.path,
                           "What is drawn: circle, line, spiral, letters, pivot (the tip rests), or the "
                           "strokes of a session (.jsonl), "
                           "drawn once"));
  group(command.add_option("--distance", a.distance, "Of the pen from the cameras")->check(metres_text()));
  group(command.add_option("--speed", a.speed, "Of the tip, m/s")->check(CLI::Range(0.001, 2.0)));
  group(command
            .add_option("--duration", a.duration, "Strokes are drawn again until then (12s; sessions: once)")
            ->check(time_text()));
  group(command.add_option("--tremor", a.tremor, "Of the hand at 9 Hz, root mean square")
            ->check(metres_text()));
  group(command.add_option("--tip-offset", a.tip_offset, "From the tip to the first LED")
            ->check(metres_text()));
  group(command.add_option("--hide", a.hide, "LEDs that are never seen: tip, or 1 to 4, such as tip,3")
            ->check(parses("LEDS", [](const std::string& text) { hidden_leds(text); })));
  group(command.add_option("--hand", a.hand, "A hand covers LEDs for up to this long")->check(time_text()));
  group(command.add_option("--false-blobs", a.false_blobs, "Reflections and lamps in each image")
            ->check(CLI::Range(0, 20)));
  group(command.add_flag("--sun", a.sun, "Spots of the sun now and then"));
  group(command.add_flag("--unsynchronised", a.unsynchronised, "Cameras run freely; wiimotes always do"));
  group(command
            .add_option("--calibration-error", a.calibration_error,
                        "The right camera is off the rig by a turn and a share of its focal length, such as "
                        "0.02deg,0.1%")
            ->check(parses("ANGLE,SHARE", [](const std::string& text) {
              SimulatePenOptions options;
              read_calibration_error(text, options);
            })));
  group(command.add_option("--rig-output", a.rig_output,
                           "Write the rig as its user believes it to be (.json)"));
  group(
      command.add_option("--images", a.images,
                         "A folder for what each camera sees (.pgm), with a list of times for batten track"));
  group(command.add_option("--corners", a.corners,
                           "Corners of a chessboard before these cameras (.csv), 20 pairs, for batten rig "
                           "calibrate"));
  group(command.add_flag("--imu", a.imu, "Readings of an inertial sensor in the pen, 200 Hz"));
}

Outcome run_simulate_pen(const SimulatePenArguments& arguments, const std::string& output,
                         const std::string& truth, std::uint64_t seed, const Progress& progress) {
  Outcome outcome;
  SimulatePenOptions options = options_of(arguments, seed);
  std::vector<Points> strokes;
  {
    const ScopedStage stage(outcome.times, "read");
    if (arguments.path == kPivot) {
      options.motion.pivot = true;
    } else if (const auto path = choices_of(PenPath{}).find(arguments.path)) {
      strokes = strokes_of(*path);
    } else {
      strokes = strokes_of_session(arguments.path);
      options.motion.turn = false;
      if (arguments.duration.empty()) options.motion.duration = 0;
    }
  }
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  SimulatedPen simulated;
  {
    const ScopedStage stage(outcome.times, "simulate");
    simulated = simulate_pen(strokes, options);
  }
  const ScopedStage stage(outcome.times, "write");
  write_blobs(simulated.recording, output);
  if (!arguments.corners.empty()) {
    SimulateBoardsOptions boards;
    boards.seed = seed;
    write_corners(simulate_boards(simulated.actual, boards), arguments.corners);
  }
  if (options.images) write_pen_images(simulated, seed, arguments.images, progress);
  if (!truth.empty()) write_file(truth, format_pen_poses(simulated.truth));
  if (!arguments.rig_output.empty()) write_rig({simulated.nominal, {}}, arguments.rig_output);
  std::size_t blobs = 0;
  for (const BlobFrame& frame : simulated.recording.frames) blobs += frame.blobs.size();
  outcome.figures["frames"] = simulated.recording.frames.size();
  outcome.figures["blobs"] = blobs;
  outcome.figures["images_of_leds"] = simulated.images_of_leds;
  outcome.figures["strokes"] = simulated.recording.buttons.size() / 2;
  outcome.figures["duration"] = simulated.truth.back().time;
  outcome.figures["output"] = output;
  outcome.lines.push_back(concat(simulated.recording.frames.size(), " frames with ", blobs, " blobs, ",
                                 simulated.recording.buttons.size() / 2, " strokes in ",
                                 simulated.truth.back().time, " s: ", output));
  if (options.images) {
    outcome.figures["images"] = simulated.recording.frames.size();
    outcome.lines.push_back(concat("images: ", arguments.images));
  }
  if (!truth.empty()) outcome.lines.push_back(concat("true poses of the pen: ", truth));
  return outcome;
}

}  // namespace batten::cli
