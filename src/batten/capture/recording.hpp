#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten {

/// What a line of a recording holds.
enum class EventKind {
  Packet,  ///< bytes of a device that answers in packets, as they came; written as hexadecimal digits
  Line,    ///< a line of the line protocol without its end, as it came
  Key,     ///< a key of the person who records, one character or a word (keys.hpp)
  State,   ///< what became of the source: "open", "lost REASON", "back", "silent REASON", "end"
};

constexpr auto choices_of(EventKind) {
  return choices<EventKind>("kind of event", {{EventKind::Packet, "packet"},
                                              {EventKind::Line, "line"},
                                              {EventKind::Key, "key"},
                                              {EventKind::State, "state"}});
}

/// Something that happened while recording, before anything is decoded.
struct CaptureEvent {
  std::int64_t time_us = 0;  ///< host time since the recording began, microseconds, at least 0
  std::string source;        ///< a word: "device", "keys"
  EventKind kind = EventKind::State;
  std::string payload;  ///< any bytes

  bool operator==(const CaptureEvent&) const = default;
};

/// `12.345678,device,packet,0a0b…` with a line end. Text has everything but printable ASCII, and the
/// backslash, as `\xHH`, so that any payload makes one line and comes back as it was.
std::string format_event(const CaptureEvent& event);
/// @throws InvalidInput in words when the line (without its end) is no event.
CaptureEvent parse_event(std::string_view line);

/// What is known when a recording begins: all that decoding needs beside the events.
struct RecordingHeader {
  static constexpr int kVersion = 1;

  std::string source;             ///< as given to `batten capture`
  std::optional<double> wheel_m;  ///< circumference of the wheel
  std::optional<DeviceAxes> axes;
  std::optional<int> n_nodes;              ///< as given; below 10 a digit is a node at once
  std::optional<std::string> form;         ///< word of a PacketForm, where it was told
  std::optional<std::string> calibration;  ///< a calibration file as one line of JSON
};

/// A recording as it was read.
struct Recording {
  RecordingHeader header;
  std::vector<CaptureEvent> events;
  std::vector<std::string> warnings;  ///< lines that could not be read, a torn last line
};

/// Reads a recording (docs/files.md, "Recordings"). A last line without its end is what a killed run or a
/// full disk leaves: it is dropped and told. Other lines that cannot be read are left out and told.
/// @throws FileError: no recording, one of a newer version, one that ends within its header.
Recording read_recording(const std::string& path);
/// The same from memory; `name` stands for the path in errors.
Recording parse_recording(std::string_view text, const std::string& name);

/// Writes a recording, line by line at the end of the file. What append() has returned from survives the
/// death of the process; what sync() has returned from, or is older than a second, that of the computer.
class RecordingWriter {
 public:
  /// Begins the file with its header. Devices such as /dev/full are written as they are.
  /// @param overwrite whether a file that holds something already may be replaced.
  /// @throws FileError where it exists, its folder is missing, or it cannot be written.
  RecordingWriter(const std::string& path, const RecordingHeader& header, bool overwrite = false);
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Writes the events in one go, and syncs where the last time was a second of the events ago.
  /// @throws FileError where the disk is full; what was written before is kept.
  void append(const std::vector<CaptureEvent>& events);
  /// Waits until everything is on the disk.
  void sync();

 private:
  void write(std::string_view bytes);

  std::string path_;
  int file_ = -1;
  std::int64_t written_until_us_ = 0, synced_us_ = 0;
};

}  // namespace batten
