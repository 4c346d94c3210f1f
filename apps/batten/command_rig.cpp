#include "command.hpp"
#include "command_group.hpp"
#include "rig_input.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "batten/camera/wand.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/rig_io.hpp"
#include "batten/io/wand_io.hpp"
#include "batten/pipeline/calibrated_rig.hpp"
#include "batten/rotation/so3.hpp"

namespace batten::cli {

namespace {

struct CalibrateArguments {
  std::vector<std::string> inputs;
  std::string output, board = "9x6", square = "25mm", size, lens = "auto", corners;
};

struct CheckArguments {
  std::string rig, input, board, square, length = "160mm";
};

struct WandArguments {
  std::string rig, input, output, length = "160mm";
};

double metres(const std::string& text) {
  return parse_length(text).in_file_units(0);
}

Json pair_json(const PairFigures& pair) {
  return {{"pair", pair.number},
          {"rms_px", pair.rms},
          {"epipolar_px", pair.epipolar},
          {"left_out", pair.left_out}};
}

Json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json camera_json(const Camera& camera) {
  return {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}, {"k1", camera.k1},
          {"k2", camera.k2}, {"k3", camera.k3}, {"p1", camera.p1}, {"p2", camera.p2}};
}

void add_check(const RigCheck& check, Json& figures) {
  figures["epipolar_px"] = check.epipolar;
  figures["epipolar_rms_px"] = check.epipolar_rms;
  figures["neighbour_mean"] = check.neighbour_mean;
  figures["neighbour_std"] = check.neighbour_std;
  figures["rigid_rms"] = check.rigid_rms;
}

std::string check_line(const RigCheck& check) {
  return concat("epipolar error ", check.epipolar, " px (", check.epipolar_rms,
                " px rms); neighbouring corners ", check.neighbour_mean, " +- ", check.neighbour_std,
                " squares apart");
}

Json calibration_json(const CalibratedRigRun& run) {
  const RigCalibration& calibration = run.calibration;
  const StereoRig& rig = calibration.calibrated.rig;
  const RigFigures& figures = calibration.calibrated.figures;
  Json json = Json::object();
  json["pairs"] = figures.pairs;
  json["corners"] = figures.corners;
  json["left_out"] = figures.left_out;
  json["lens"] = word_of(figures.lens);
  json["rms_px"] = figures.rms;
  json["left_rms_px"] = figures.left_rms;
  json["right_rms_px"] = figures.right_rms;
  add_check(run.check, json);
  json["held_back_px"] = figures.held_back;
  json["baseline_m"] = rig.baseline();
  json["left_coverage"] = figures.left_coverage;
  json["right_coverage"] = figures.right_coverage;
  json["tilt_deg"] = degrees(figures.tilt);
  json["left"] = camera_json(rig.left);
  json["right"] = camera_json(rig.right);
  json["rotation_deg"] = vector_json(so3_log(rig.rotation) * degrees(1.0));
  json["translation_m"] = vector_json(rig.translation);
  const RigDeviations& deviations = figures.deviations;
  json["standard_deviations"] = {{"left", camera_json(deviations.left)},
                                 {"right", camera_json(deviations.right)},
                                 {"rotation_deg", vector_json(deviations.rotation * degrees(1.0))},
                                 {"translation_m", vector_json(deviations.translation)}};
  json["trials"] = Json::array();
  for (const LensTrial& trial : calibration.trials)
    json["trials"].push_back(
        {{"lens", word_of(trial.lens)}, {"held_back_px", trial.held_back}, {"rms_px", trial.rms}});
  json["each"] = Json::array();
  for (const PairFigures& pair : calibration.pairs) json["each"].push_back(pair_json(pair));
  return json;
}

Outcome run_calibrate(const CalibrateArguments& arguments, Context& context) {
  Outcome outcome;
  BoardPairs pairs;
  {
    const ScopedStage stage(outcome.times, "read");
    const Board board = parse_board(arguments.board, metres(arguments.square));
    pairs = read_board_pairs(arguments.inputs, board, arguments.size, outcome.warnings, context.progress);
  }
  RigCalibrationOptions options;
  if (arguments.lens != "auto") options.lens = parse_choice<LensModel>(arguments.lens);
  if (!arguments.corners.empty()) write_corners(pairs, arguments.corners);
  const CalibratedRigRun run = calibrated_rig(pairs, options, context.progress);
  add_run(run.times, run.warnings, outcome);
  {
    const ScopedStage stage(outcome.times, "write");
    write_rig(run.calibration.calibrated, arguments.output);
  }
  outcome.figures = calibration_json(run);
  outcome.figures["output"] = arguments.output;
  const RigFigures& figures = run.calibration.calibrated.figures;
  const StereoRig& rig = run.calibration.calibrated.rig;
  outcome.lines = {
      concat(figures.pairs, " pairs, ", figures.corners, " corners (", figures.left_out, " left out) lie ",
             figures.rms, " px (rms) from where the rig sees them"),
      check_line(run.check),
      concat("focal lengths ", rig.left.fx, " +- ", figures.deviations.left.fx, " and ", rig.right.fx, " +- ",
             figures.deviations.right.fx, " px; baseline ", 1000 * rig.baseline(), " mm"),
      concat("rig: ", arguments.output)};
  return outcome;
}

constexpr double kKnocked = 2;  // times the epipolar error at calibration

void warn_if_knocked(const CalibratedRig& rig, double before, double now, Outcome& outcome) {
  if (rig.figures.pairs > 0 && before > 0 && now > kKnocked * before)
    outcome.warnings.push_back(concat("the epipolar error was ", before, " px at calibration and is ", now,
                                      " px now; a camera was moved, or this is of another rig"));
}

BoardPairs corners_for(const CalibratedRig& rig, const CheckArguments& arguments,
                       std::vector<std::string>& warnings) {
  Board board = rig.figures.board;
  if (!arguments.square.empty()) board.square = metres(arguments.square);
  if (!arguments.board.empty()) board = parse_board(arguments.board, board.square);
  const Camera& left = rig.rig.left;
  return read_corners(arguments.input, {.board = board, .size = ImageSize{left.width, left.height}},
                      &warnings);
}

Outcome check_with_board(const CheckArguments& arguments, const CalibratedRig& rig) {
  Outcome outcome;
  BoardPairs pairs;
  {
    const ScopedStage stage(outcome.times, "read");
    pairs = corners_for(rig, arguments, outcome.warnings);
  }
  RigCheck check;
  {
    const ScopedStage stage(outcome.times, "check");
    check = check_rig(rig.rig, pairs);
  }
  outcome.figures["pairs"] = check.pairs;
  outcome.figures["corners"] = check.corners;
  outcome.figures["lost"] = check.lost;
  add_check(check, outcome.figures);
  outcome.figures["each"] = Json::array();
  for (const PairFigures& pair : check.each)
    outcome.figures["each"].push_back(
        {{"pair", pair.number}, {"epipolar_px", pair.epipolar}, {"rigid_rms", pair.rms}});
  warn_if_knocked(rig, rig.figures.epipolar, check.epipolar, outcome);
  outcome.lines = {concat(check.pairs, " pairs, ", check.corners, " corners seen by both cameras"),
                   check_line(check)};
  return outcome;
}

Json wand_json(const WandCheck& check) {
  return {{"frames", check.frames},        {"unused", check.unused},
          {"epipolar_px", check.epipolar}, {"epipolar_rms_px", check.epipolar_rms},
          {"length_m", check.length},      {"length_std_m", check.length_std},
          {"length_trend_m", check.trend}};
}

std::string wand_line(const WandCheck& check) {
  return concat("epipolar error ", check.epipolar, " px (", check.epipolar_rms, " px rms); length ",
                1000 * check.length, " +- ", 1000 * check.length_std, " mm");
}

Outcome check_with_wand(const CheckArguments& arguments, const CalibratedRig& rig) {
  Outcome outcome;
  WandCheck check;
  {
    const ScopedStage stage(outcome.times, "check");
    const std::vector<WandFrame> frames = read_wand(arguments.input);
    check = check_wand(rig.rig, frames, {.lights = wand_lights(frames, metres(arguments.length))});
  }
  outcome.figures = wand_json(check);
  warn_if_knocked(rig, rig.figures.epipolar_rms, check.epipolar_rms, outcome);
  constexpr double kWrongLength = 0.005;
  const double nominal = metres(arguments.length);
  if (std::abs(check.length - nominal) > kWrongLength * nominal)
    outcome.warnings.push_back(concat("the wand measures ", 1000 * check.length, " mm and is ",
                                      1000 * nominal, " mm long; mend the rig with batten rig wand"));
  outcome.lines = {concat(check.frames, " frames with all lights in both images"), wand_line(check)};
  return outcome;
}

Outcome run_check(const CheckArguments& arguments) {
  const CalibratedRig rig = read_rig(arguments.rig);
  return file_extension(arguments.input) == "jsonl" ? check_with_wand(arguments, rig)
                                                    : check_with_board(arguments, rig);
}

Outcome run_wand(const WandArguments& arguments, Context& context) {
  Outcome outcome;
  CalibratedRig rig;
  std::vector<WandFrame> frames;
  {
    const ScopedStage stage(outcome.times, "read");
    rig = read_rig(arguments.rig);
    frames = read_wand(arguments.input);
  }
  WandCalibration found;
  {
    const ScopedStage stage(outcome.times, "adjust");
    found = calibrate_wand(rig.rig, frames, {.lights = wand_lights(frames, metres(arguments.length))},
                           context.progress);
  }
  rig.rig = found.rig;
  rig.figures.epipolar = found.after.epipolar;
  rig.figures.epipolar_rms = found.after.epipolar_rms;
  rig.figures.deviations.rotation = found.rotation_deviation;
  rig.figures.deviations.translation = found.translation_deviation;
  {
    const ScopedStage stage(outcome.times, "write");
    write_rig(rig, arguments.output);
  }
  outcome.figures["frames"] = found.after.frames;
  outcome.figures["left_out"] = found.left_out;
  outcome.figures["rms_px"] = found.rms;
  outcome.figures["before"] = wand_json(found.before);
  outcome.figures["after"] = wand_json(found.after);
  outcome.figures["baseline_m"] = rig.rig.baseline();
  outcome.figures["rotation_deg"] = vector_json(so3_log(rig.rig.rotation) * degrees(1.0));
  outcome.figures["translation_m"] = vector_json(rig.rig.translation);
  outcome.figures["standard_deviations"] = {
      {"rotation_deg", vector_json(found.rotation_deviation * degrees(1.0))},
      {"translation_m", vector_json(found.translation_deviation)}};
  outcome.figures["output"] = arguments.output;
  outcome.lines = {concat("before: ", wand_line(found.before)), concat("after: ", wand_line(found.after)),
                   concat("rig: ", arguments.output)};
  return outcome;
}

void add_length_option(CLI::App& command, const std::string& name, std::string& value,
                       const char* description) {
  command.add_option(name, value, description)->check(parses("LENGTH", [name](const std::string& text) {
    const Length length = parse_length(text);
    if (length.kind == Length::Kind::Relative || !(length.value > 0))
      throw InvalidInput(concat(name, " must be a length above 0, such as 25mm, got '", text, "'"));
  }));
}

void add_board_option(CLI::App& command, std::string& board, const char* description) {
  command.add_option("--board", board, description)
      ->check(parses("COLUMNSxROWS", [](const std::string& text) {
        if (const auto found = parse_board(text, 1).problem()) throw InvalidInput(*found);
      }));
}

void add_calibrate_command(CLI::App& group) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* command =
      add_command(group, "calibrate", "Calibrate two cameras from pairs of images of a chessboard",
                  "batten rig calibrate corners.csv -o rig.json --board 9x6 --square 25mm",
                  [arguments](Context& context) { return run_calibrate(*arguments, context); });
  command
      ->add_option(
          "inputs", arguments->inputs,
          "Corners (.csv), or images (.png, .jpg, .pgm): those of one pair have the same number, and "
          "left or right in their names")
      ->required();
  command->add_option("-o,--output", arguments->output, "The rig (.json)")->required();
  add_board_option(*command, arguments->board, "Inner corners of the board along its sides");
  add_length_option(*command, "--square", arguments->square, "Side of a square");
  command
      ->add_option("--image-size", arguments->size,
                   "Size of the images, for corners that do not come with it")
      ->check(parses("WIDTHxHEIGHT", [](const std::string& text) { parse_image_size(text); }));
  command->add_option("--lens", arguments->lens, "Coefficients of the lens; auto: what fits pairs held back")
      ->check(CLI::IsMember([] {
        std::vector<std::string> words = choice_words<LensModel>();
        words.insert(words.begin(), "auto");
        return words;
      }()));
  command->add_option("--corners", arguments->corners, "Write the corners found in images (.csv)");
}

void add_check_command(CLI::App& group) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* command =
      add_command(group, "check", "Measure how well a rig fits corners of a chessboard, or a waved wand",
                  "batten rig check rig.json corners.csv --json",
                  [arguments](Context&) { return run_check(*arguments); });
  command->add_option("rig", arguments->rig, "The rig (.json)")->required();
  command
      ->add_option("input", arguments->input,
                   "Corners of pairs of images (.csv), or blobs of a waved wand or pen (.jsonl)")
      ->required();
  add_board_option(*command, arguments->board, "Inner corners; those of the calibration when left out");
  add_length_option(*command, "--square", arguments->square,
                    "Side of a square; that of the calibration when left out");
  add_length_option(*command, "--length", arguments->length, "Distance of the outer lights of the wand");
}

void add_wand_command(CLI::App& group) {
  auto arguments = std::make_shared<WandArguments>();
  CLI::App* command =
      add_command(group, "wand", "Find how the cameras stand to each other from a waved wand or pen",
                  "batten rig wand rig.json blobs.jsonl -o better.json --length 160mm",
                  [arguments](Context& context) { return run_wand(*arguments, context); });
  command
      ->add_option("rig", arguments->rig, "The rig (.json), its cameras right and the rest to some degrees")
      ->required();
  command->add_option("blobs", arguments->input, "Blobs of both cameras (.jsonl)")->required();
  command->add_option("-o,--output", arguments->output, "The rig, cameras as they were (.json)")->required();
  add_length_option(*command, "--length", arguments->length, "Distance of the outer lights");
}

}  // namespace

void add_rig(CLI::App& app) {
  CLI::App* group = add_group(app, "rig", "Calibrate, check and mend a pair of cameras");
  add_calibrate_command(*group);
  add_check_command(*group);
  add_wand_command(*group);
}

}  // namespace batten::cli
