#include "command.hpp"
#include "pen_arguments.hpp"
#include "pen_image_files.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "batten/capture/pen_accuracy.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/blobs_io.hpp"
#include "batten/io/file.hpp"
#include "batten/io/pen_io.hpp"
#include "batten/pipeline/tracked_pen.hpp"
#include "batten/session/journal.hpp"

namespace batten::cli {

namespace {

struct TrackArguments {
  std::string input, rig, output, tip, truth, method = "bundle", lag = "30ms", tip_offset = "60mm",
                                              spacing = "1mm", gaussian = "25ms", pen;
  bool exact_rig = false;
};

constexpr double kMillimetres = 1e3;

Json errors_json(const PenErrors& errors) {
  return {{"frames", errors.frames},
          {"mean_mm", kMillimetres * errors.mean},
          {"rms_mm", kMillimetres * errors.rms},
          {"p95_mm", kMillimetres * errors.p95},
          {"below_2mm", errors.below_2mm},
          {"direction_p95_deg", degrees(errors.direction_p95)}};
}

std::string errors_line(const char* which, const PenErrors& errors) {
  return concat(which, ": mean ", kMillimetres * errors.mean, " mm, 95 % below ", kMillimetres * errors.p95,
                " mm, ", 100 * errors.below_2mm, " % below 2 mm");
}

/// The figures of a track against its truth.
Json accuracy_json(const PenAccuracy& accuracy, const PenTrack& track) {
  Json json = {{"current", errors_json(accuracy.current)},
               {"lagged", errors_json(accuracy.lagged)},
               {"smoothed", errors_json(accuracy.smoothed)}};
  json["bands"] = Json::array();
  for (const PenErrorBand& band : accuracy.bands) {
    Json entry = {{"from_m", band.from}, {"to_m", band.to}};
    entry.update(errors_json(band.lagged));
    json["bands"].push_back(entry);
  }
  const long answered = track.report.tracked + track.report.bridged;
  json["wrong_identities"] = accuracy.wrong_identities;
  json["wrong_identity_share"] =
      answered > 0 ? static_cast<double>(accuracy.wrong_identities) / static_cast<double>(answered) : 0.0;
  json["answerable"] = accuracy.answerable;
  json["answered_share"] = accuracy.answerable > 0 ? static_cast<double>(accuracy.answered) /
                                                         static_cast<double>(accuracy.answerable)
                                                   : 0.0;
  json["frame_alone"] = {
      {"frames", accuracy.single_frames},
      {"rms_mm", kMillimetres * accuracy.single_rms},
      {"bound_mm", kMillimetres * accuracy.bound_rms},
      {"rms_by_bound", accuracy.bound_rms > 0 ? accuracy.single_rms / accuracy.bound_rms : 0.0}};
  json["mean_chi_square"] = accuracy.mean_chi_square;
  return json;
}

std::string tip_text(const PenTrack& track, const std::vector<ButtonEvent>& buttons) {
  std::size_t next = 0;
  bool drawing = false;
  std::string text = "time_s,camera,state,x,y,z,dx,dy,dz,sigma_m,drawing,reason\n";
  for (const PenSample& sample : track.samples) {
    for (; next < buttons.size() && buttons[next].time <= sample.time; ++next)
      if (buttons[next].button == "draw") drawing = buttons[next].down;
    text += exact_decimal(sample.time);
    text += sample.camera == CameraSide::Left ? ",left," : ",right,";
    text += word_of(sample.state);
    if (sample.state == PenState::Lost) {
      std::string reason = sample.reason;
      std::replace(reason.begin(), reason.end(), ',', ';');  // the table has one column for it
      text += (drawing ? ",,,,,,,,1," : ",,,,,,,,0,") + reason + "\n";
      continue;
    }
    for (const double value : sample.pose.tip) (text += ',') += exact_decimal(value);
    for (const double value : sample.pose.direction) (text += ',') += exact_decimal(value);
    const double variance = sample.covariance.topLeftCorner<3, 3>().trace();
    (text += ',') += exact_decimal(std::sqrt(std::max(0.0, variance)));
    text += drawing ? ",1,\n" : ",0,\n";
  }
  return text;
}

void write_strokes(const PenStrokes& strokes, const std::string& path) {
  std::vector<Edit> edits;
  AddEdit model;
  model.object = {1};
  model.name = "model";
  model.unit = "m";
  model.content = SharedModel();
  edits.push_back(model);
  for (const PenStroke& stroke : strokes.strokes) {
    InsertEdit insert;
    insert.stroke.points = stroke.points;
    edits.push_back(ModelEdit{{1}, insert, 0});
  }
  write_session(path, edits);
}

TrackedPenOptions options_of(const TrackArguments& arguments) {
  TrackedPenOptions options;
  if (!arguments.pen.empty())
    options.pen = read_pen(arguments.pen).pen;
  else
    options.pen.tip_offset = metres(arguments.tip_offset);
  options.method = parse_choice<PenMethod>(arguments.method);
  options.track.lag = seconds(arguments.lag);
  options.triangulated.gaussian = seconds(arguments.gaussian);
  options.strokes.spacing = metres(arguments.spacing);
  if (arguments.exact_rig) options.track.rotation_sigma = options.track.focal_sigma = 0;
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  return options;
}

void describe(const TrackedPen& tracked, Outcome& outcome) {
  const TrackReport& report = tracked.track.report;
  Json& figures = outcome.figures;
  figures["frames"] = report.frames;
  figures["tracked"] = report.tracked;
  figures["bridged"] = report.bridged;
  figures["lost"] = report.lost;
  figures["lost_because"] = Json::object();
  for (const auto& [reason, frames] : report.lost_because) figures["lost_because"][reason] = frames;
  figures["searches"] = report.searches;
  figures["strokes"] = tracked.strokes.strokes.size();
  figures["slips"] = tracked.strokes.slips;
  figures["broken"] = tracked.strokes.broken;
  figures["rig_turn_deg"] = degrees(report.rig_turn.norm());
  figures["rig_turn_sigma_deg"] = degrees(report.rig_turn_sigma.norm());
  figures["rig_focal"] = report.rig_focal;
  figures["rig_focal_sigma"] = report.rig_focal_sigma;
  outcome.lines.push_back(concat(report.tracked, " of ", report.frames, " frames tracked, ", report.bridged,
                                 " bridged, ", report.lost, " lost; ", tracked.strokes.strokes.size(),
                                 " strokes"));
  for (const auto& [reason, frames] : report.lost_because)
    outcome.lines.push_back(concat("  lost in ", frames, " frames: ", reason));
}

Outcome run_track(const TrackArguments& arguments, const Progress& progress) {
  const TrackedPenOptions options = options_of(arguments);
  Outcome outcome;
  StereoRig rig;
  std::vector<TimedPose> truth;
  {
    const ScopedStage stage(outcome.times, "read");
    rig = rig_named(arguments.rig);
    if (!arguments.truth.empty()) truth = read_pen_poses(arguments.truth);
  }
  const BlobRecording recording = read_pen_recording(arguments.input, rig, outcome, progress);
  TrackedPen tracked;
  try {
    tracked = tracked_pen(recording, rig, options);
  } catch (const FileError&) {
    throw;
  } catch (const InvalidInput& error) {
    throw FileError(arguments.input, 0, error.what());
  }
  add_run(tracked.times, tracked.warnings, outcome);
  describe(tracked, outcome);
  if (!arguments.truth.empty()) {
    const ScopedStage stage(outcome.times, "compare");
    PenAccuracy accuracy;
    try {
      accuracy = pen_accuracy(recording, tracked.track, options.pen, truth);
    } catch (const InvalidInput& error) {
      throw FileError(arguments.truth, 0, error.what());
    }
    outcome.figures["accuracy"] = accuracy_json(accuracy, tracked.track);
    outcome.lines.push_back(errors_line("tip without lag", accuracy.current));
    outcome.lines.push_back(errors_line("tip with lag", accuracy.lagged));
    outcome.lines.push_back(errors_line("tip smoothed", accuracy.smoothed));
    outcome.lines.push_back(concat("frames alone: rms ", kMillimetres * accuracy.single_rms,
                                   " mm, Cramer-Rao bound ", kMillimetres * accuracy.bound_rms,
                                   " mm; wrong identities in ", accuracy.wrong_identities, " frames"));
    if (options.method == PenMethod::Bundle) {
      // The way of the thesis beside ours, on the same blobs.
      const PenTrack thesis = track_pen_by_triangulation(recording, rig, options.pen, options.triangulated);
      const PenAccuracy theirs = pen_accuracy(recording, thesis, options.pen, truth);
      outcome.figures["accuracy_triangulate"] = accuracy_json(theirs, thesis);
      outcome.lines.push_back(errors_line("by triangulation, frame by frame", theirs.current));
      outcome.lines.push_back(errors_line("by triangulation and a Gaussian", theirs.lagged));
    }
  }
  const ScopedStage stage(outcome.times, "write");
  write_strokes(tracked.strokes, arguments.output);
  if (!arguments.tip.empty()) write_file(arguments.tip, tip_text(tracked.track, recording.buttons));
  outcome.figures["output"] = arguments.output;
  outcome.lines.push_back(concat("strokes: ", arguments.output));
  return outcome;
}

}  // namespace

void add_track(CLI::App& app) {
  auto arguments = std::make_shared<TrackArguments>();
  TrackArguments& a = *arguments;
  CLI::App* command =
      add_command(app, "track", "Follow a pen through the images of two cameras",
                  "batten track blobs.jsonl --rig rig.json -o session.jsonl --tip tip.csv",
                  [arguments](Context& context) { return run_track(*arguments, context.progress); });
  command
      ->add_option(
          "blobs", a.input,
          "What the cameras saw: blobs (.jsonl, docs/files.md#blobs), or a folder of images with its "
          "frames.jsonl")
      ->required();
  command
      ->add_option("--rig", a.rig,
                   "The cameras: rig.json of batten rig calibrate, or wiimote, vga or global as simulated")
      ->required();
  command->add_option("-o,--output", a.output, "The strokes, a session for batten sketch (.jsonl)")
      ->required();
  command->add_option("--tip", a.tip, "Write tip, direction and state of every frame (.csv)");
  command->add_option("--truth", a.truth, "True poses (.csv); prints errors, and those of the thesis's way");
  command->add_option("--method", a.method, "bundle or triangulate")
      ->check(CLI::IsMember(choice_words<PenMethod>()));
  command->add_option("--lag", a.lag, "How long an answer waits for later frames")->check(time_text());
  command->add_option("--pen", a.pen, "The pen, as batten pen calibrate writes it (.json)");
  command->add_option("--tip-offset", a.tip_offset, "From the tip to the first LED")->check(metres_text());
  command->add_option("--spacing", a.spacing, "Least distance between the points of a stroke")
      ->check(metres_text());
  command->add_option("--gaussian", a.gaussian, "triangulate: standard deviation of the smoothing over time")
      ->check(time_text());
  command->add_flag("--exact-rig", a.exact_rig, "Do not correct the rig while tracking");
}

}  // namespace batten::cli
