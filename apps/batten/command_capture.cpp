#include "command.hpp"
#include "commands/capture.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <unistd.h>

#include "batten/capture/terminal_keys.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/pipeline/recorded_capture.hpp"

namespace batten::cli {

namespace {

struct CaptureArguments {
  std::string source, output, calibration, wheel, form;
  bool list = false, preview = false, overwrite = false;
  int nodes = 0;
  double seconds = 0;
};

struct ReplayArguments {
  std::string recording;
  double speed = 1;
};

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

/// The live view as one line of a terminal.
std::string preview_line(const PreviewState& s) {
  std::string line = concat(two_digits(static_cast<double>(s.time_us) * 1e-6), " s  ", std::lround(s.rate_hz),
                            " Hz ± ", two_digits(1000 * s.jitter_s), " ms  ");
  if (s.source.substr(0, 4) == "lost") return line + s.source;
  if (s.drawing)
    line += concat("curve ", s.n_curves, s.paused ? " (pause) " : " ", two_digits(1000 * s.distance_m),
                   " mm at (", two_digits(1000 * s.position.x()), ", ", two_digits(1000 * s.position.y()),
                   ", ", two_digits(1000 * s.position.z()), ")");
  else
    line += concat(s.n_curves, " curves, ", s.n_nodes, " nodes; + begins a curve");
  if (s.drift_m) line += concat("  drift ", two_digits(1000 * *s.drift_m), " mm at node ", s.drift_node);
  if (s.n_gaps + s.n_missing > 0) line += concat("  ", s.n_gaps, " gaps, ", s.n_missing, " missing");
  if (!s.digits.empty()) line += concat("  node ", s.digits, "_");
  return line;
}

/// Shows the live view: on a terminal one line that is written anew, elsewhere a line for every two seconds.
class PreviewPrinter {
 public:
  void operator()(const PreviewState& state) {
    const bool terminal = isatty(STDERR_FILENO) != 0;
    const std::int64_t every = terminal ? 100000 : 2000000;
    if (shown_us_ >= 0 && state.time_us - shown_us_ < every && state.source == source_) return;
    shown_us_ = state.time_us;
    source_ = state.source;
    std::fprintf(stderr, terminal ? "\r\033[K%s" : "%s\n", preview_line(state).c_str());
  }

 private:
  std::int64_t shown_us_ = -1;
  std::string source_;
};

void tell(RecordedCapture& result, Outcome& outcome) {
  add_run(result.times, result.warnings, outcome);
  const CaptureReport& report = result.report;
  commands::append(commands::figures_of(result), outcome.figures);
  outcome.lines.push_back(concat(report.end, " after ", two_digits(report.seconds), " s: ", report.n_events,
                                 " events, ", report.n_losses, " losses"));
  if (result.decoded)
    outcome.lines.push_back(concat(result.decoded->log.curves.size(), " curves, ",
                                   result.decoded->log.n_readings(), " readings, ",
                                   result.decoded->report.n_refused, " refused"));
}

Outcome list_all() {
  Outcome outcome;
  outcome.figures["sources"] = Json::array();
  for (const auto& [source, what] : list_sources()) {
    outcome.figures["sources"].push_back({{"source", source}, {"what", what}});
    outcome.lines.push_back(concat(source, "   (", what, ")"));
  }
  return outcome;
}

Outcome run_capture(const CaptureArguments& arguments, Context& context) {
  if (arguments.list) return list_all();
  if (arguments.source.empty())
    throw CLI::ValidationError("SOURCE: is required; batten capture --list shows what there is");
  if (arguments.output.empty()) throw CLI::ValidationError("--output: is required; name a .blog file");
  RecordedCaptureOptions options;
  options.source = arguments.source;
  options.recording = arguments.output;
  options.overwrite = arguments.overwrite;
  options.capture.seconds = arguments.seconds;
  if (!arguments.wheel.empty()) options.wheel_m = parse_length(arguments.wheel).value;
  if (arguments.nodes > 0) options.n_nodes = arguments.nodes;
  if (!arguments.form.empty()) options.form = parse_choice<PacketForm>(arguments.form);
  if (!arguments.calibration.empty())
    options.calibration = commands::calibration_line(read_file(arguments.calibration), arguments.calibration);
  Outcome outcome;
  CaptureHooks hooks;
  TerminalKeys keys;
  hooks.keys = [&keys] { return keys.read(); };
  PreviewPrinter printer;
  if (arguments.preview) hooks.update = [&printer](const PreviewState& state) { printer(state); };
  RecordedCapture result = record_capture(options, hooks, context.progress);
  tell(result, outcome);
  outcome.figures["output"] = arguments.output;
  outcome.lines.push_back(concat("recording: ", arguments.output));
  return outcome;
}

Outcome run_replay(const ReplayArguments& arguments, Context& context) {
  Outcome outcome;
  CaptureHooks hooks;
  PreviewPrinter printer;
  hooks.update = [&printer](const PreviewState& state) { printer(state); };
  RecordedCapture result =
      replay_recording(read_recording(arguments.recording), arguments.speed, hooks, context.progress);
  tell(result, outcome);
  return outcome;
}

}  // namespace

void add_capture(CLI::App& app) {
  auto arguments = std::make_shared<CaptureArguments>();
  CaptureArguments& a = *arguments;
  CLI::App* command =
      add_command(app, "capture", "Record what a device measures while curves are traced on an object",
                  "batten capture line:/dev/ttyUSB0@230400 -o hull.blog --preview",
                  [arguments](Context& context) { return run_capture(*arguments, context); });
  command
      ->add_option("SOURCE", a.source,
                   "morphorider:/dev/ttyUSB0, line:/dev/ttyUSB0@230400, ws://, udp:9000, file:recording.blog "
                   "or simulator:sphere?option=value&...")
      ->check(parses("SOURCE", [](const std::string& text) { parse_source(text); }));
  command->add_option("-o,--output", a.output, "The recording (.blog)");
  command->add_flag("--list", a.list, "List the sources that there are");
  command->add_option("--calibration", a.calibration,
                      "Calibration of the device (.json), kept in the recording");
  command->add_option("--wheel", a.wheel, "Circumference of the wheel, such as 62.8mm")
      ->check(parses("LENGTH", [](const std::string& text) {
        const Length length = parse_length(text);
        if (length.kind == Length::Kind::Relative || !(length.value > 0 && length.value < 100))
          throw InvalidInput(concat("the wheel must be a length above 0 and below 100 m, got ", text));
      }));
  command
      ->add_option("--form", a.form,
                   "Form of a Morphorider's packets: be-sm, be-tc, le-sm, le-tc; else recognised")
      ->check(parses("FORM", [](const std::string& text) { parse_choice<PacketForm>(text); }));
  command->add_option("--nodes", a.nodes, "Nodes of the network; below 10, one digit is a node at once")
      ->check(CLI::Range(0, 1000000));
  command->add_option("--seconds", a.seconds, "Record for so long; 0: until q or Ctrl-C")
      ->check(CLI::Range(0.0, 1e7));
  command->add_flag("--preview", a.preview, "Show the device's way, drift, rate and gaps while it moves");
  command->add_flag("--overwrite", a.overwrite, "Replace an existing recording");
}

void add_replay(CLI::App& app) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command = add_command(app, "replay", "Play a recording of batten capture with its preview",
                                  "batten replay hull.blog --speed 4",
                                  [arguments](Context& context) { return run_replay(*arguments, context); });
  command->add_option("RECORDING", arguments->recording, "A recording (.blog)")->required();
  command->add_option("--speed", arguments->speed, "Times as fast as it was made; 0: as fast as it goes")
      ->check(CLI::Range(0.0, 1000.0));
}

}  // namespace batten::cli
