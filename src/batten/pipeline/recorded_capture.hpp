#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/capture/capture.hpp"
#include "batten/capture/decode.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"

namespace batten {

/// What to capture, and where to. The defaults are those of `batten capture`.
struct RecordedCaptureOptions {
  std::string source;                      ///< as parse_source() reads it
  std::string recording;                   ///< file to write
  bool overwrite = false;                  ///< replace a file that holds something
  std::optional<std::string> calibration;  ///< of the device, as JSON text (docs/files.md, "Calibrations")
  std::optional<double> wheel_m;           ///< circumference of the wheel, metres
  std::optional<int> n_nodes;              ///< of the network, at least 1; below 10 a digit is a node at once
  std::optional<PacketForm> form;          ///< of a Morphorider's packets; nothing: recognised
  CaptureOptions capture;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A capture, and what is in its recording.
struct RecordedCapture {
  CaptureReport report;
  std::optional<DecodedRecording> decoded;  ///< nothing where there is nothing to decode; a warning says why
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Captures a source into a recording, tells every change of its live view to hooks.update, and decodes the
/// recording at the end. Where Progress asks to stop, the capture ends as by hooks.stop, and the recording is
/// whole.
/// @throws InvalidInput with the remedy, FileError; what was recorded before is kept in any case.
RecordedCapture record_capture(const RecordedCaptureOptions& options, const CaptureHooks& hooks = {},
                               const Progress& progress = {});

/// Plays a recording `speed` times as fast as it was made, or as fast as it goes with 0, as if it came from a
/// device.
/// @throws InvalidInput where speed is out of range [0, 1000].
RecordedCapture replay_recording(const Recording& recording, double speed, const CaptureHooks& hooks = {},
                                 const Progress& progress = {});

}  // namespace batten
