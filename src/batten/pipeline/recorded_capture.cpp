#include "batten/pipeline/recorded_capture.hpp"

#include <memory>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// Hooks that stop where Progress asks for it.
CaptureHooks with_progress(const CaptureHooks& hooks, const Progress& progress) {
  CaptureHooks all = hooks;
  all.stop = [&hooks, &progress] {
    if (hooks.stop && hooks.stop()) return true;
    try {
      progress.report("capture", 0);
    } catch (const Cancelled&) {
      return true;
    }
    return false;
  };
  return all;
}

void decode(const Recording& recording, RecordedCapture& result) {
  const ScopedStage stage(result.times, "decode");
  try {
    result.decoded = decode_recording(recording);
    result.warnings = result.decoded->warnings;
  } catch (const InvalidInput& error) {
    result.warnings = recording.warnings;
    result.warnings.emplace_back(error.what());
  }
}

}  // namespace

std::optional<std::string> RecordedCaptureOptions::problem() const {
  if (source.empty()) return "source must name a source";
  if (recording.empty()) return "recording must name a file";
  if (wheel_m && !(*wheel_m > 0 && *wheel_m < 100))
    return concat("wheel_m must be above 0 and below 100, got ", *wheel_m);
  if (n_nodes && !(*n_nodes >= 1 && *n_nodes <= 1000000))
    return concat("n_nodes must lie in [1, 1000000], got ", *n_nodes);
  return capture.problem();
}

RecordedCapture record_capture(const RecordedCaptureOptions& options, const CaptureHooks& hooks,
                               const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  RecordedCapture result;
  const SourceSpec spec = parse_source(options.source);
  const std::unique_ptr<HostClock> clock = make_clock(spec);
  const std::unique_ptr<Source> source = make_source(spec, *clock);
  RecordingHeader header;
  if (source->header() != nullptr) header = *source->header();
  header.source = options.source;
  if (options.wheel_m) header.wheel_m = options.wheel_m;
  if (options.n_nodes) header.n_nodes = options.n_nodes;
  if (options.form) header.form = std::string(word_of(*options.form));
  if (options.calibration) header.calibration = options.calibration;
  Recording recording;
  {
    const ScopedStage stage(result.times, "capture");
    RecordingWriter writer(options.recording, header, options.overwrite);
    const auto record = [&writer](const std::vector<CaptureEvent>& events) {
      writer.append(events);
      for (const CaptureEvent& event : events)
        if (event.kind == EventKind::Key && (event.payload == "." || event.payload == "end")) writer.sync();
    };
    result.report = capture(*source, *clock, header, record, options.capture, with_progress(hooks, progress));
  }
  try {
    recording = read_recording(options.recording);
  } catch (const FileError&) {
    result.warnings.push_back(
        concat(options.recording, " cannot be read back; its recording was not decoded"));
    return result;
  }
  decode(recording, result);
  return result;
}

RecordedCapture replay_recording(const Recording& recording, double speed, const CaptureHooks& hooks,
                                 const Progress& progress) {
  if (!(speed >= 0 && speed <= 1000)) throw InvalidInput(concat("speed must lie in [0, 1000], got ", speed));
  RecordedCapture result;
  {
    const ScopedStage stage(result.times, "replay");
    std::unique_ptr<HostClock> clock = std::make_unique<VirtualClock>();
    if (speed > 0) clock = std::make_unique<SteadyClock>(speed);
    const std::unique_ptr<Source> source = make_replay_source(recording, *clock);
    result.report = capture(*source, *clock, recording.header, {}, {}, with_progress(hooks, progress));
  }
  decode(recording, result);
  return result;
}

}  // namespace batten
