#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/capture/preview.hpp"
#include "batten/capture/source.hpp"

namespace batten {

/// When a capture ends and how patient it is. Times are of the clock it is given.
struct CaptureOptions {
  double seconds = 0;     ///< to record; 0: until it is stopped or the source ends
  double patience_s = 5;  ///< without anything that can be read at first, before it gives up; above 0
  double reopen_s = 0.5;  ///< between attempts to open a source that was lost; above 0

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What a capture is connected with. All may be empty.
struct CaptureHooks {
  /// Keys pressed since the last call; "q" ends the capture.
  std::function<std::vector<std::string>()> keys;
  /// Whether to end.
  std::function<bool()> stop;
  /// Told every change of the live view, from the thread that called capture().
  std::function<void(const PreviewState&)> update;
};

/// What came of a capture.
struct CaptureReport {
  long n_events = 0;
  long n_answers = 0;       ///< packets and lines
  long n_losses = 0;        ///< times that the source was lost
  double seconds_lost = 0;  ///< until it answered again
  double seconds = 0;
  double latency_95_s = 0;  ///< from a reading's arrival to its update: 95 % of the last thousand are below
  double largest_latency_s = 0;
  std::string end;  ///< why it ended, in words
  PreviewState last;
};

/// Runs a source until its end: records what comes, keys included, follows it with a preview, and opens the
/// source anew where it is lost; the gap is marked by "lost" and "back".
/// @param record takes the events of every turn, in order; may throw to end the capture.
/// @throws InvalidInput with the remedy where the source cannot be opened, or nothing that can be read comes
/// from it in `patience_s`; what `record` throws. Everything before was recorded.
CaptureReport capture(Source& source, HostClock& clock, const RecordingHeader& header,
                      const std::function<void(const std::vector<CaptureEvent>&)>& record,
                      const CaptureOptions& options = {}, const CaptureHooks& hooks = {});

}  // namespace batten
