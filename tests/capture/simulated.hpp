#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "batten/capture/capture.hpp"
#include "batten/capture/decode.hpp"
#include "batten/capture/recording.hpp"
#include "batten/capture/source.hpp"

namespace batten::test {

/// What a capture of a source left behind, without a file.
struct Captured {
  Recording recording;
  CaptureReport report;
};

/// Captures a source of the command line to its end. With `speed=max` in it nothing depends on real time.
inline Captured captured(const std::string& source_text, const CaptureOptions& options = {},
                         const CaptureHooks& hooks = {}) {
  Captured result;
  const SourceSpec spec = parse_source(source_text);
  const std::unique_ptr<HostClock> clock = make_clock(spec);
  const std::unique_ptr<Source> source = make_source(spec, *clock);
  result.recording.header.source = source_text;
  result.recording.header.wheel_m = 0.0628;
  const auto record = [&](const std::vector<CaptureEvent>& events) {
    result.recording.events.insert(result.recording.events.end(), events.begin(), events.end());
  };
  result.report = capture(*source, *clock, result.recording.header, record, options, hooks);
  return result;
}

/// A recording as it would stand in a file.
inline std::string text_of(const Recording& recording) {
  std::string text =
      "#batten-recording 1\n#source test\n#wheel_m 0.0628\n#events seconds,source,kind,payload\n";
  for (const CaptureEvent& event : recording.events) text += format_event(event);
  return text;
}

}  // namespace batten::test
