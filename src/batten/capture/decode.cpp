#include "batten/capture/decode.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/capture/readings_detail.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace batten {

namespace {

// A wheel of 20 mm, as the reference device has.
constexpr double kUsualWheel = 0.0628;
// Stretches without readings that are told (seconds).
constexpr double kLongestPause = 0.5;
// Orientations of a device are handed on as the vectors that would show them, with this inclination.
constexpr double kInclination = kPi / 3;

void report_gaps(const Recording& recording, const detail::Readings& readings, DecodedRecording& decoded) {
  DecodeReport& report = decoded.report;
  if (!recording.events.empty())
    report.seconds =
        static_cast<double>(recording.events.back().time_us - recording.events.front().time_us) * 1e-6;
  for (const CaptureEvent& event : recording.events)
    if (event.kind == EventKind::State && event.payload.substr(0, 4) == "lost") ++report.n_losses;
  const auto& r = readings.readings;
  for (std::size_t i = 1; i < r.size(); ++i) {
    const double gap = static_cast<double>(r[i].time_us - r[i - 1].time_us) * 1e-6;
    if (gap > kLongestPause) report.seconds_lost += gap;
  }
  if (report.n_losses > 0)
    decoded.warnings.push_back(concat("the device was lost ", report.n_losses, " times, ",
                                      report.seconds_lost, " s are without readings"));
  if (report.n_clock_jumps > 0)
    decoded.warnings.push_back(concat("the clock of the device was set ", report.n_clock_jumps,
                                      " times while recording; times go by the computer's"));
}

void add_calibration(const Recording& recording, DecodedRecording& decoded) {
  if (recording.header.calibration)
    decoded.calibration =
        parse_calibration(*recording.header.calibration, "the calibration in the recording");
}

}  // namespace

std::optional<std::string> DecodeOptions::problem() const {
  if (wheel_m && !(*wheel_m > 0 && *wheel_m < 100))
    return concat("wheel_m must be above 0 and below 100, got ", *wheel_m);
  if (!(accelerometer_range > 0))
    return concat("accelerometer_range must be above 0, got ", accelerometer_range);
  if (!(magnetometer_range > 0))
    return concat("magnetometer_range must be above 0, got ", magnetometer_range);
  return std::nullopt;
}

void detail::add_packet_readings(const Recording& recording, const DecodeOptions& options, Readings& readings,
                                 DecodedRecording& decoded) {
  DecodeReport& report = decoded.report;
  std::vector<std::string> packets;
  std::vector<std::int64_t> times;
  for (const CaptureEvent& event : recording.events) {
    if (event.kind != EventKind::Packet) continue;
    ++report.n_packets;
    if (event.payload.size() != MorphoriderPacket::kBytes) {
      ++report.n_short;
      continue;
    }
    packets.push_back(event.payload);
    times.push_back(times.empty() ? event.time_us : std::max(event.time_us, times.back()));
  }
  if (packets.empty()) return;
  PacketForm form{};
  if (options.form) {
    form = *options.form;
  } else if (recording.header.form) {
    form = parse_choice<PacketForm>(*recording.header.form);
  } else {
    report.form = recognise_form(packets);
    form = report.form->form;
    if (!report.form->settled)
      decoded.warnings.push_back(concat("the form of the packets is not certain and was taken for ",
                                        word_of(form),
                                        "; turn the device over before drawing, or give --form"));
  }
  std::optional<double> wheel = options.wheel_m ? options.wheel_m : recording.header.wheel_m;
  if (!wheel) {
    wheel = kUsualWheel;
    decoded.warnings.emplace_back(
        "the circumference of the wheel was not told and was taken for 62.8 mm; give --wheel");
  }
  const PacketDecision decision = decide_packets(packets, times, form);
  report.n_restarts = decision.n_restarts;
  std::int64_t last_index = -1;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    using Fate = PacketDecision::Fate;
    report.n_refused += decision.fate[i] == Fate::Refused ? 1 : 0;
    report.n_duplicates += decision.fate[i] == Fate::Duplicate ? 1 : 0;
    if (decision.fate[i] != Fate::Kept) continue;
    const MorphoriderPacket packet = decode_packet(packets[i], form);
    Reading reading;
    reading.time_us = times[i];
    reading.distance = static_cast<double>(decision.ticks[i]) / MorphoriderPacket::kTicksPerTurn * *wheel;
    reading.distance_lost_before = decision.distance_lost_before[i];
    reading.accelerometer = options.accelerometer_range * packet.accelerometer;
    reading.magnetometer = options.magnetometer_range * packet.magnetometer;
    readings.readings.push_back(reading);
    if (last_index >= 0) report.n_missing += decision.index[i] - last_index - 1;
    last_index = decision.index[i];
  }
  report.n_missing = std::max(0L, report.n_missing - report.n_refused);
}

DecodedRecording decode_recording(const Recording& recording, const DecodeOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  DecodedRecording decoded;
  decoded.warnings = recording.warnings;
  detail::Readings readings;
  detail::add_packet_readings(recording, options, readings, decoded);
  detail::add_line_readings(recording, readings, decoded);
  if (readings.readings.empty())
    throw InvalidInput(
        decoded.report.n_packets + decoded.report.n_lines > 0
            ? concat("none of the ", decoded.report.n_packets + decoded.report.n_lines,
                     " answers in the recording can be read; is the baud rate right, e.g. @115200?")
            : "the recording holds no readings; was the device connected and switched on?");
  for (const CaptureEvent& event : recording.events)
    if (event.kind == EventKind::Key) readings.keys.emplace_back(event.time_us, event.payload);
  std::stable_sort(readings.keys.begin(), readings.keys.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  add_calibration(recording, decoded);
  if (recording.header.axes) readings.axes = *recording.header.axes;
  detail::lay_out_curves(recording, readings, decoded);
  report_gaps(recording, readings, decoded);
  return decoded;
}

LogScan scan_from_recording(const DecodedRecording& decoded, const std::optional<Calibration>& calibration) {
  const bool calibrated = calibration || decoded.calibration;
  const bool has_vectors =
      !decoded.log.accelerometer.array().isNaN().all() && !decoded.log.magnetometer.array().isNaN().all();
  if (decoded.log.curves.empty())
    throw InvalidInput(
        "the recording has no curve; press + at its beginning and . at its end while recording");
  LogScanOptions options;
  if (!decoded.has_orientations() || (calibrated && has_vectors)) {
    if (calibration)
      options.calibration = *calibration;
    else if (decoded.calibration)
      options.calibration = *decoded.calibration;
    LogScan scan = scan_from_log(decoded.log, options);
    if (!calibrated)
      scan.warnings.emplace_back(
          "orientations were estimated without a calibration; give --calibration to batten capture or "
          "convert");
    return scan;
  }
  // The vectors that a device with this orientation would measure lead back to it exactly.
  SensorLog log = decoded.log;
  const Eigen::Vector3d up(0, 0, kUsualGravity);
  const Eigen::Vector3d field = 48 * Eigen::Vector3d(std::cos(kInclination), 0, -std::sin(kInclination));
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const Eigen::Vector4d q = decoded.orientations.row(i);
    const Eigen::Matrix3d X = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    log.accelerometer.row(i) = X.transpose() * up;
    log.magnetometer.row(i) = X.transpose() * field;
  }
  options.inclination = kInclination;
  return scan_from_log(log, options);
}

}  // namespace batten
