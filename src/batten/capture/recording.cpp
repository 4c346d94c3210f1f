#include "batten/capture/recording.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten {

namespace {

constexpr std::string_view kMagic = "#batten-recording ";
// A year: no recording is longer, and sums of times cannot overflow.
constexpr std::int64_t kLongestSeconds = std::int64_t{366} * 24 * 3600;
constexpr std::int64_t kMicroseconds = 1000000;
// How many lines that cannot be read are told one by one.
constexpr int kLinesTold = 3;

void append_hex(std::string& text, char byte) {
  constexpr char kDigits[] = "0123456789abcdef";
  const auto value = static_cast<unsigned char>(byte);
  text += kDigits[value >> 4];
  text += kDigits[value & 15];
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

/// Two hexadecimal digits at `at` as a byte.
char hex_byte(std::string_view text, std::size_t at) {
  const int high = at + 1 < text.size() ? hex_digit(text[at]) : -1;
  const int low = at + 1 < text.size() ? hex_digit(text[at + 1]) : -1;
  if (high < 0 || low < 0) throw InvalidInput("expected two hexadecimal digits");
  return static_cast<char>(high * 16 + low);
}

std::string escaped(std::string_view text) {
  std::string line;
  for (const char c : text) {
    if (c >= ' ' && c <= '~' && c != '\\') {
      line += c;
    } else {
      line += "\\x";
      append_hex(line, c);
    }
  }
  return line;
}

std::string unescaped(std::string_view line) {
  std::string text;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != '\\') {
      text += line[i];
      continue;
    }
    if (i + 1 >= line.size() || line[i + 1] != 'x') throw InvalidInput("expected \\xHH after a backslash");
    text += hex_byte(line, i + 2);
    i += 3;
  }
  return text;
}

std::int64_t parse_time(std::string_view text) {
  const std::size_t point = text.find('.');
  const auto all_digits = [](std::string_view digits) {
    return !digits.empty() &&
           std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  if (point == std::string_view::npos || !all_digits(text.substr(0, point)) || point > 9 ||
      text.size() != point + 7 || !all_digits(text.substr(point + 1)))
    throw InvalidInput("expected seconds with six digits behind the point");
  std::int64_t time = 0;
  for (const char c : text)
    if (c != '.') time = 10 * time + (c - '0');
  if (time > kLongestSeconds * kMicroseconds) throw InvalidInput("the time is later than a year");
  return time;
}

std::string axis_word(const Eigen::Vector3d& axis) {
  Eigen::Index k = 0;
  axis.cwiseAbs().maxCoeff(&k);
  return concat(axis[k] < 0 ? '-' : '+', "xyz"[k]);
}

/// "+x,+z": forward and normal.
std::optional<DeviceAxes> parse_axes(std::string_view text) {
  DeviceAxes axes;
  const std::vector<std::string_view> words = split_fields(text, ',');
  if (words.size() != 2) return std::nullopt;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string_view word = words[i];
    if (word.size() != 2 || (word[0] != '+' && word[0] != '-') || word[1] < 'x' || word[1] > 'z')
      return std::nullopt;
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();
    axis[word[1] - 'x'] = word[0] == '-' ? -1 : 1;
    (i == 0 ? axes.forward : axes.normal) = axis;
  }
  if (axes.forward.dot(axes.normal) != 0) return std::nullopt;
  return axes;
}

std::string header_text(const RecordingHeader& header) {
  std::string text = concat(kMagic, RecordingHeader::kVersion, "\n#source ", escaped(header.source), "\n");
  if (header.wheel_m) text += concat("#wheel_m ", exact_decimal(*header.wheel_m), "\n");
  if (header.axes)
    text += concat("#axes ", axis_word(header.axes->forward), ",", axis_word(header.axes->normal), "\n");
  if (header.n_nodes) text += concat("#nodes ", *header.n_nodes, "\n");
  if (header.form) text += concat("#form ", escaped(*header.form), "\n");
  if (header.calibration) text += concat("#calibration ", escaped(*header.calibration), "\n");
  return text + "#events seconds,source,kind,payload\n";
}

/// A line of the header behind its first. Keys that are not known are those of later additions.
void understand_header(std::string_view line, long number, const std::string& name, RecordingHeader& header) {
  const std::size_t blank = std::min(line.find(' '), line.size());
  const std::string_view key = line.substr(1, blank - 1), value = trim(line.substr(blank));
  const auto fail = [&](std::string_view expected) {
    throw FileError(name, number, concat("expected ", expected, " in the header of the recording"));
  };
  if (key == "source" || key == "form" || key == "calibration") {
    try {
      const std::string text = unescaped(value);
      if (key == "source")
        header.source = text;
      else
        (key == "form" ? header.form : header.calibration) = text;
    } catch (const InvalidInput& error) {
      throw FileError(name, number, error.what());
    }
  } else if (key == "wheel_m") {
    double wheel = 0;
    if (!parse_number(value, wheel) || !(wheel > 0 && wheel < 100)) fail("the circumference of the wheel, m");
    header.wheel_m = wheel;
  } else if (key == "axes") {
    header.axes = parse_axes(value);
    if (!header.axes) fail("axes of the device like +x,+z");
  } else if (key == "nodes") {
    long nodes = 0;
    if (!parse_integer(value, nodes) || nodes < 1 || nodes > 1000000) fail("the number of nodes");
    header.n_nodes = static_cast<int>(nodes);
  }
}

void check_version(std::string_view first, bool whole, const std::string& name) {
  if (!whole && (first.size() < kMagic.size() + 1) && kMagic.substr(0, first.size()) == first)
    throw FileError(name, 0, "the recording ends within its header: nothing was recorded; record again");
  long version = 0;
  if (first.substr(0, kMagic.size()) != kMagic ||
      !parse_integer(trim(first.substr(kMagic.size())), version) || version < 1)
    throw FileError(name, 1, "is no recording of batten capture; its first line is #batten-recording 1");
  if (version > RecordingHeader::kVersion)
    throw FileError(name, 1,
                    concat("the recording has version ", version, ", this program reads up to ",
                           RecordingHeader::kVersion, "; take a newer batten"));
}

}  // namespace

std::string format_event(const CaptureEvent& event) {
  char time[32];
  std::snprintf(time, sizeof time, "%lld.%06lld", static_cast<long long>(event.time_us / kMicroseconds),
                static_cast<long long>(event.time_us % kMicroseconds));
  std::string line = concat(time, ",", event.source, ",", word_of(event.kind), ",");
  if (event.kind == EventKind::Packet)
    for (const char byte : event.payload) append_hex(line, byte);
  else
    line += escaped(event.payload);
  return line + "\n";
}

CaptureEvent parse_event(std::string_view line) {
  CaptureEvent event;
  const auto field = [&line] {
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos) throw InvalidInput("expected seconds,source,kind,payload");
    const std::string_view text = line.substr(0, comma);
    line.remove_prefix(comma + 1);
    return text;
  };
  event.time_us = parse_time(field());
  event.source = field();
  if (event.source.empty() || !std::all_of(event.source.begin(), event.source.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
      }))
    throw InvalidInput("expected the name of a source in small letters");
  event.kind = parse_choice<EventKind>(field());
  if (event.kind != EventKind::Packet) {
    event.payload = unescaped(line);
    return event;
  }
  if (line.size() % 2 != 0) throw InvalidInput("expected two hexadecimal digits per byte");
  for (std::size_t i = 0; i < line.size(); i += 2) event.payload += hex_byte(line, i);
  return event;
}

Recording parse_recording(std::string_view text, const std::string& name) {
  Recording recording;
  long number = 0;
  int n_unreadable = 0;
  bool in_header = true;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = text.find('\n', at);
    const bool whole = end != std::string_view::npos;
    const std::string_view line = text.substr(at, whole ? end - at : std::string_view::npos);
    at = whole ? end + 1 : text.size();
    if (++number == 1) check_version(line, whole, name);
    if (!whole) {
      if (in_header)
        throw FileError(name, number,
                        "the recording ends within its header: nothing was recorded; record again");
      recording.warnings.push_back(
          concat("the last line of the recording (", number, ") is torn and was left out"));
      break;
    }
    if (number == 1) continue;
    if (in_header && !line.empty() && line.front() == '#') {
      understand_header(line, number, name, recording.header);
      if (line.substr(0, 8) == "#events ") in_header = false;
      continue;
    }
    in_header = false;
    try {
      recording.events.push_back(parse_event(line));
    } catch (const InvalidInput& error) {
      if (++n_unreadable <= kLinesTold)
        recording.warnings.push_back(
            concat("line ", number, " of the recording was left out: ", error.what()));
    }
  }
  if (number == 0) throw FileError(name, 0, "the recording is empty; record again");
  if (n_unreadable > kLinesTold)
    recording.warnings.push_back(concat(n_unreadable, " lines of the recording were left out in all"));
  return recording;
}

Recording read_recording(const std::string& path) {
  return parse_recording(read_file(path), path);
}

RecordingWriter::RecordingWriter(const std::string& path, const RecordingHeader& header, bool overwrite)
    : path_(path) {
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISREG(status.st_mode) && status.st_size > 0 && !overwrite)
    throw FileError(path, 0, "exists already; recordings are not replaced, give another name or --overwrite");
  int flags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC;
  if (exists && S_ISREG(status.st_mode)) flags |= O_TRUNC;
  file_ = ::open(path.c_str(), flags, 0666);
  if (file_ < 0)
    throw FileError(path, 0, concat("cannot be written: ", std::strerror(errno), "; does its folder exist?"));
  try {
    write(header_text(header));
    sync();
  } catch (...) {
    ::close(file_);
    throw;
  }
}

RecordingWriter::~RecordingWriter() {
  sync();
  ::close(file_);
}

void RecordingWriter::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const std::string reason =
          errno == ENOSPC || errno == EDQUOT ? "the disk is full" : std::strerror(errno);
      throw FileError(
          path_, 0,
          concat(reason, "; what was recorded until second ", static_cast<double>(written_until_us_) / 1e6,
                 " is kept, make room and record the last curve again"));
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void RecordingWriter::append(const std::vector<CaptureEvent>& events) {
  if (events.empty()) return;
  std::string text;
  for (const CaptureEvent& event : events) text += format_event(event);
  write(text);
  written_until_us_ = events.back().time_us;
  if (written_until_us_ - synced_us_ >= kMicroseconds) sync();
}

void RecordingWriter::sync() {
  ::fsync(file_);  // pipes and devices have none, and say EINVAL
  synced_us_ = written_until_us_;
}

}  // namespace batten
