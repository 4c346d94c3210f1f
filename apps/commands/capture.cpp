#include "commands/capture.hpp"

#include "batten/io/sensor_log_io.hpp"

namespace batten::commands {

namespace {

Json decoded_figures(const DecodedRecording& decoded) {
  const DecodeReport& report = decoded.report;
  Json json = Json::object();
  json["readings"] = decoded.log.n_readings();
  json["packets"] = report.n_packets;
  json["lines"] = report.n_lines;
  json["short"] = report.n_short;
  json["refused"] = report.n_refused;
  json["duplicates"] = report.n_duplicates;
  json["missing"] = report.n_missing;
  json["restarts"] = report.n_restarts;
  json["clock_rate"] = report.clock_rate;
  json["form"] = report.form ? Json(std::string(word_of(report.form->form))) : Json(nullptr);
  return json;
}

}  // namespace

std::string calibration_line(std::string_view text, const std::string& name) {
  parse_calibration(std::string(text), name);
  return Json::parse(text).dump();
}

Json figures_of(const RecordedCapture& capture) {
  const CaptureReport& report = capture.report;
  Json figures = Json::object();
  figures["end"] = report.end;
  figures["recorded_s"] = report.seconds;
  figures["events"] = report.n_events;
  figures["losses"] = report.n_losses;
  figures["lost_s"] = report.seconds_lost;
  figures["rate_hz"] = report.last.rate_hz;
  figures["jitter_ms"] = 1000 * report.last.jitter_s;
  figures["latency_95_ms"] = 1000 * report.latency_95_s;
  figures["largest_latency_ms"] = 1000 * report.largest_latency_s;
  figures["drift_mm"] = report.last.drift_m ? Json(1000 * *report.last.drift_m) : Json(nullptr);
  figures["curves"] = capture.decoded ? capture.decoded->log.curves.size() : 0;
  if (capture.decoded) figures["decoded"] = decoded_figures(*capture.decoded);
  return figures;
}

}  // namespace batten::commands
