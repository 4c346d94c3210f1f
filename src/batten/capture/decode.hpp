#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/capture/morphorider.hpp"
#include "batten/capture/recording.hpp"
#include "batten/core/units.hpp"
#include "batten/scan/calibration.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten {

/// What decoding is told beside the recording; fields without a value are taken from its header.
struct DecodeOptions {
  std::optional<double> wheel_m;   ///< circumference of a Morphorider's wheel, metres, above 0
  std::optional<PacketForm> form;  ///< of a Morphorider's packets; nothing: recognised
  /// What a full scale of the Morphorider's sensors stands for. S does not say; directions do not depend on
  /// it.
  double accelerometer_range = 2 * kUsualGravity;  ///< m/s²
  double magnetometer_range = 130;                 ///< µT

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What was believed of a recording and what not.
struct DecodeReport {
  long n_packets = 0;       ///< answers of a device in packets
  long n_short = 0;         ///< answers cut short
  long n_refused = 0;       ///< packets that do not fit their neighbours, or lines with a wrong check
  long n_duplicates = 0;    ///< packets or lines that came twice
  long n_lines = 0;         ///< lines of the line protocol
  long n_missing = 0;       ///< samples that the counts of the device say are not there
  long n_losses = 0;        ///< times that the source was lost
  double seconds_lost = 0;  ///< without readings: stretches of more than half a second
  long n_restarts = 0;      ///< times that the device began to count anew
  long n_clock_jumps = 0;   ///< times that its clock was set
  double clock_rate = 1;    ///< host seconds per second of the device
  double seconds = 0;       ///< from the first event to the last
  std::optional<FormRecognition> form;  ///< of packets
};

/// The readings of a recording.
struct DecodedRecording {
  SensorLog log;  ///< readings between curves are kept, on no curve
  /// n × 4 quaternions w x y z, device → world, as the device gave them; NaN where there is none.
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> orientations;
  std::optional<Calibration> calibration;  ///< of the header
  DecodeReport report;
  std::vector<std::string> warnings;

  bool has_orientations() const { return !orientations.array().isNaN().all(); }
};

/// Turns a recording into readings with curves and nodes: a function of the recording alone, the same for the
/// recording of a device and for that of its replay.
///
/// Curves run from `+` or `-` to `.`; a node lies at all readings from 0.3 s before its key to 0.3 s after it
/// at which the wheel stands where it stood at the key. Distances begin with each curve, do not count what
/// the wheel turned in a pause, and where it turned back stand still. Curves during which the wheel may have
/// turned uncounted, or with fewer than two readings, are left out and told. Unnumbered nodes get numbers of
/// their own.
/// @throws InvalidInput in words when there are no readings at all, or an option is out of range.
DecodedRecording decode_recording(const Recording& recording, const DecodeOptions& options = {});

/// The scan of decoded readings. Orientations are those of accelerometer and magnetometer where a calibration
/// is at hand or the device gives no others, else those of the device (docs/capture.md#orientations).
/// @param calibration in place of the one in the recording. @throws InvalidInput as scan_from_log().
LogScan scan_from_recording(const DecodedRecording& decoded,
                            const std::optional<Calibration>& calibration = std::nullopt);

}  // namespace batten
