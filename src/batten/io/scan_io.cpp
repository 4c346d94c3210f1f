#include "batten/io/scan_io.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/io/scan_text_detail.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace batten {

namespace {

using detail::one_line;
using detail::quoted;

constexpr int kNumbersPerReading = 7;  // distance, tangent, normal
using Reading = std::array<double, kNumbersPerReading>;

// A direction shorter than this is none. Files round to four digits or more.
constexpr double kSmallestDirection = 1e-3;
// As in check_scan(): below this sine of the angle between tangent and normal (3 degrees) there is no frame.
constexpr double kSmallestSine = 0.05;

/// Readings of one curve in blocks, so that a count that lies cannot exhaust the memory and growing does
/// not copy what is there.
class ReadingStore {
 public:
  void append(const Reading& reading) {
    if (count_ % kBlock == 0) {
      blocks_.emplace_back();
      blocks_.back().reserve(kBlock);
    }
    blocks_.back().push_back(reading);
    ++count_;
  }

  /// Moves the readings into the curve, releasing block after block.
  void move_to(ScanCurve& curve) {
    const auto n = static_cast<Eigen::Index>(count_);
    curve.distances.resize(n);
    curve.tangents.resize(n, 3);
    curve.normals.resize(n, 3);
    Eigen::Index i = 0;
    for (; !blocks_.empty(); blocks_.pop_front())
      for (const Reading& r : blocks_.front()) {
        curve.distances[i] = r[0];
        curve.tangents.row(i) << r[1], r[2], r[3];
        curve.normals.row(i) << r[4], r[5], r[6];
        ++i;
      }
    count_ = 0;
  }

 private:
  static constexpr size_t kBlock = 4096;
  std::deque<std::vector<Reading>> blocks_;
  size_t count_ = 0;
};

std::string_view without_comment(std::string_view line) {
  return trim(line.substr(0, line.find('#')));
}

/// Takes the next token off `rest`; empty at the end.
std::string_view take_token(std::string_view& rest) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  size_t begin = 0;
  while (begin < rest.size() && blank(rest[begin])) ++begin;
  size_t end = begin;
  while (end < rest.size() && !blank(rest[end])) ++end;
  const std::string_view token = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return token;
}

/// Scales to unit length unless it has that already, so that a file written by us reads back unchanged.
bool normalize(double* v) {
  const double squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (!(squared > kSmallestDirection * kSmallestDirection)) return false;
  if (std::abs(squared - 1) <= 8 * std::numeric_limits<double>::epsilon()) return true;
  const double length = std::sqrt(squared);
  for (int k = 0; k < 3; ++k) v[k] /= length;
  return true;
}

/// The value of a comment `# key: value`, or empty.
std::string_view comment_value(std::string_view line, std::string_view key) {
  line = trim(line);
  if (line.empty() || line.front() != '#') return {};
  line = trim(line.substr(1));
  if (line.substr(0, key.size()) != key) return {};
  line = trim(line.substr(key.size()));
  if (line.empty() || line.front() != ':') return {};
  return trim(line.substr(1));
}

/// Reads rawnet content from one or several files.
class RawnetParser {
 public:
  RawnetParser(LineReader& in, bool may_open_files, NodeNumbers numbers)
      : in_(in), may_open_files_(may_open_files), numbers_(numbers) {}

  Scan parse() {
    const long count = whole_number("the number of curves", 0);
    if (count == 0)
      parse_files();
    else
      for (long c = 0; c < count; ++c) parse_curve(c + 1, count);
    std::string_view line;
    if (content_line(line))
      in_.fail(concat("expected the end of the file after ", scan_.curves.size(), " curves, found ",
                      quoted(line), "; correct the number of curves or of readings"));
    detail::check_node_numbers(nodes_);
    try {
      const bool has_all = std::none_of(nodes_.begin(), nodes_.end(), [](const detail::NodeEntry& node) {
        return node.id == kNoNodeNumber;
      });
      check_scan(scan_, has_all ? numbers_ : NodeNumbers::MayMiss);
    } catch (const FileError&) {
      throw;
    } catch (const InvalidInput& error) {
      throw FileError(root_path_, 0, error.what());
    }
    return std::move(scan_);
  }

 private:
  /// The next line that is neither blank nor comment, without its comment. False at the end of the file.
  bool content_line(std::string_view& content) {
    std::string_view line;
    while (in_.next(line)) {
      content = without_comment(line);
      if (!content.empty()) return true;
      understand_comment(line);
    }
    return false;
  }

  void understand_comment(std::string_view line) {
    if (const std::string_view unit = comment_value(line, "unit"); !unit.empty()) scan_.unit = unit;
    if (const std::string_view name = comment_value(line, "name"); !name.empty()) name_ = name;
    if (const std::string_view tangents = comment_value(line, "tangents"); !tangents.empty()) {
      if (tangents == "to-next")
        scan_.tangents = TangentConvention::ToNext;
      else if (tangents == "at-sample")
        scan_.tangents = TangentConvention::AtSample;
      else
        in_.fail(concat("tangents are \"to-next\" or \"at-sample\", not ", quoted(tangents)));
    }
  }

  std::string_view expected_line(const std::string& what) {
    std::string_view line;
    if (!content_line(line))
      throw FileError(
          in_.path(), in_.line_number() + 1,
          concat("the file ends here, expected ", what, "; the file is cut off or a count is too large"));
    return line;
  }

  long whole_number(const std::string& what, long smallest) {
    const std::string_view line = expected_line(what);
    long value = 0;
    if (!parse_integer(line, value) || value < smallest || value > std::numeric_limits<int>::max())
      in_.fail(concat("expected ", what, ", a whole number from ", smallest, ", found ", quoted(line),
                      hint_after_count_));
    return value;
  }

  /// One digit from 0 to `most` on a line.
  int digit(const std::string& what, int most) {
    const std::string_view line = expected_line(what);
    if (line.size() != 1 || line[0] < '0' || line[0] > '0' + most)
      in_.fail(concat("expected ", what, ", found ", quoted(line), hint_after_count_));
    return line[0] - '0';
  }

  /// `count` whole numbers on one line. @param may_miss "?" stands for kNoNodeNumber.
  std::vector<int> whole_numbers(const std::string& what, long count, bool may_miss = false) {
    std::string_view rest = expected_line(what);
    std::vector<int> values;
    for (std::string_view token = take_token(rest); !token.empty(); token = take_token(rest)) {
      long value = 0;
      if (may_miss && token == "?")
        value = kNoNodeNumber;
      else if (!parse_integer(token, value) || value < 0 || value > std::numeric_limits<int>::max())
        in_.fail(concat("expected ", what, ", found ", quoted(token)));
      values.push_back(static_cast<int>(value));
    }
    if (static_cast<long>(values.size()) != count)
      in_.fail(concat("expected ", what, ": ", count, " numbers as announced, found ", values.size()));
    return values;
  }

  void parse_curve(long number, long count) {
    const std::string of_curve = concat(" of curve ", number, " of ", count);
    ScanCurve curve;
    name_.clear();
    const int kind =
        digit(concat("the boundary flag", of_curve, ", 1 (boundary), 0 (interior) or 2 (sharp)"), 2);
    curve.boundary = kind == 1;
    curve.sharp = kind == 2;
    hint_after_count_.clear();
    curve.closed = digit(concat("the closed flag", of_curve, ", 1 (closed) or 0 (open)"), 1) == 1;
    const long n_nodes = whole_number(concat("the number of nodes", of_curve), 0);
    long line_of_positions = 0;
    if (n_nodes > 0) {
      curve.node_readings = whole_numbers(concat("the positions of the nodes", of_curve), n_nodes);
      line_of_positions = in_.line_number();
      curve.node_ids = whole_numbers(concat("the numbers of the nodes", of_curve), n_nodes, true);
      for (const int id : curve.node_ids) nodes_.push_back({id, in_.path(), in_.line_number()});
    }
    const long n_readings = whole_number(concat("the number of readings", of_curve), 0);
    if (n_readings < 2)
      in_.fail(concat("curve ", number, " has ", n_readings, " reading", n_readings == 1 ? "" : "s",
                      "; a curve needs at least 2, remove it or record it again"));
    check_positions(curve, number, n_readings, line_of_positions);
    ReadingStore readings;
    Reading reading{};
    Reading previous{};
    for (long i = 0; i < n_readings; ++i) {
      parse_reading(reading, number, i, n_readings);
      if (i > 0 && reading[0] < previous[0])
        in_.fail(concat("the distance falls from ", previous[0], " to ", reading[0], " at reading ", i + 1,
                        " of curve ", number, "; distances must not decrease along a curve"));
      readings.append(reading);
      previous = reading;
    }
    readings.move_to(curve);
    curve.name = name_;
    hint_after_count_ = concat("; curve ", number, " was to have ", n_readings, " readings");
    scan_.curves.push_back(std::move(curve));
  }

  /// Positions in the file count from 1; in memory from 0.
  void check_positions(ScanCurve& curve, long number, long n_readings, long line) const {
    int previous = 0;
    for (int& position : curve.node_readings) {
      if (position < 1 || position > n_readings)
        throw FileError(in_.path(), line,
                        concat("node position ", position, " of curve ", number, " is outside 1 … ",
                               n_readings, ", the readings of this curve; positions count from 1"));
      if (position <= previous)
        throw FileError(in_.path(), line,
                        concat("node position ", position, " of curve ", number, " follows ", previous,
                               "; positions must increase along the curve"));
      previous = position--;
    }
  }

  void parse_reading(Reading& reading, long curve, long i, long n) {
    std::string_view line;
    if (!content_line(line))
      throw FileError(in_.path(), in_.line_number() + 1,
                      concat("the file ends after ", i, " of ", n, " readings of curve ", curve,
                             "; it is cut off or the number of readings is wrong"));
    std::string_view rest = line;
    for (int k = 0; k < kNumbersPerReading; ++k) {
      const std::string_view token = take_token(rest);
      double& value = reading[static_cast<size_t>(k)];
      if (token.empty() || !parse_number(token, value)) fail_reading(line, curve, i, n);
      if (!std::isfinite(value))
        in_.fail(concat("reading ", i + 1, " of curve ", curve, " holds ", quoted(token),
                        ", expected finite numbers; remove this reading"));
    }
    if (!take_token(rest).empty()) fail_reading(line, curve, i, n);
    if (!normalize(&reading[1]))
      in_.fail(concat("the tangent of reading ", i + 1, " of curve ", curve,
                      " has no length; remove this reading"));
    if (!normalize(&reading[4]))
      in_.fail(concat("the normal of reading ", i + 1, " of curve ", curve,
                      " has no length; remove this reading"));
    const Eigen::Vector3d tangent(reading[1], reading[2], reading[3]);
    const Eigen::Vector3d normal(reading[4], reading[5], reading[6]);
    if (tangent.cross(normal).norm() < kSmallestSine)
      in_.fail(concat("tangent and normal of reading ", i + 1, " of curve ", curve,
                      " are parallel; they must be at right angles, remove this reading"));
  }

  [[noreturn]] void fail_reading(std::string_view line, long curve, long i, long n) const {
    in_.fail(concat("expected 7 numbers (distance, tangent, normal) for reading ", i + 1, " of ", n,
                    " of curve ", curve, ", found ", quoted(line)));
  }

  void parse_files() {
    std::string_view line;
    if (!content_line(line)) in_.fail("the file has no curves; record at least one");
    long count = 0;
    if (!parse_integer(line, count) || count < 1 || count > std::numeric_limits<int>::max())
      in_.fail(concat("after a first line of 0 expected the number of files, one per curve, found ",
                      quoted(line)));
    if (!may_open_files_) in_.fail("a list of files per curve can only be read from a file");
    const size_t slash = in_.path().find_last_of("/\\");
    const std::string folder = slash == std::string::npos ? "" : in_.path().substr(0, slash + 1);
    for (long c = 0; c < count; ++c) {
      std::string file(expected_line(concat("the path of the file of curve ", c + 1, " of ", count)));
      if (file.front() != '/') file.insert(0, folder);
      LineReader curve_lines = [&] {
        try {
          return LineReader(file);
        } catch (const FileError& error) {
          in_.fail(concat("a first line of 0 announces a list of files, but ", error.what()));
        }
      }();
      std::swap(in_, curve_lines);
      try {
        parse_curve(c + 1, count);
        if (content_line(line))
          in_.fail(concat("expected the end of the file after one curve, found ", quoted(line)));
      } catch (...) {
        std::swap(in_, curve_lines);
        throw;
      }
      std::swap(in_, curve_lines);
    }
  }

  LineReader& in_;
  bool may_open_files_;
  NodeNumbers numbers_;
  std::string root_path_ = in_.path();
  Scan scan_;
  std::vector<detail::NodeEntry> nodes_;
  std::string name_;              // from the comments of the curve being read
  std::string hint_after_count_;  // said when a curve does not begin where the one before should have ended
};

std::string number_list(const std::vector<int>& values, int offset) {
  std::string line;
  for (const int value : values) {
    if (!line.empty()) line += ' ';
    line += value == kNoNodeNumber ? "?" : std::to_string(value + offset);
  }
  return line;
}

/// Told by the first line that is neither blank nor comment: a log begins with the names of its columns.
bool is_sensor_log(LineReader in) {
  std::string_view line;
  bool found = in.next(line);
  while (found && without_comment(line).empty()) found = in.next(line);
  // Scans begin with a number; `nan` and `1e5` do not hide a name.
  return found &&
         std::any_of(line.begin(), line.end(),
                     [](char c) {
                       return std::isalpha(static_cast<unsigned char>(c)) != 0 && c != 'e' && c != 'E';
                     }) &&
         line.find_first_of(",;\t") != std::string_view::npos;
}

LogScan scan_of_log(const SensorLog& log, const std::string& name, const LogScanOptions& options,
                    const std::vector<std::string>& notes) {
  try {
    LogScan scan = scan_from_log(log, options);
    scan.warnings.insert(scan.warnings.begin(), notes.begin(), notes.end());
    return scan;
  } catch (const InvalidInput& error) {
    throw FileError(name, 0, error.what());
  }
}

}  // namespace

Scan read_rawnet(const std::string& path, NodeNumbers numbers) {
  LineReader in(path);
  return RawnetParser(in, true, numbers).parse();
}

Scan parse_rawnet(std::string text, const std::string& name, NodeNumbers numbers) {
  LineReader in(std::move(text), name);
  return RawnetParser(in, false, numbers).parse();
}

std::string format_rawnet(const Scan& scan) {
  const auto is_numbered = [](const ScanCurve& curve) {
    return !curve.node_ids.empty() &&
           std::count(curve.node_ids.begin(), curve.node_ids.end(), kNoNodeNumber) == 0;
  };
  const bool has_all = std::all_of(scan.curves.begin(), scan.curves.end(), is_numbered);
  check_scan(scan, has_all ? NodeNumbers::Needed : NodeNumbers::MayMiss);
  std::string text = "# rawnet: distances, tangents and normals along curves\n";
  if (!scan.unit.empty()) text += concat("# unit: ", one_line(scan.unit), "\n");
  if (scan.tangents == TangentConvention::ToNext) text += "# tangents: to-next\n";
  if (scan.tangents == TangentConvention::AtSample) text += "# tangents: at-sample\n";
  text += concat("# number of curves\n", scan.curves.size(), "\n");
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const ScanCurve& curve = scan.curves[c];
    text += concat("# curve ", c + 1, "\n");
    if (!curve.name.empty()) text += concat("# name: ", one_line(curve.name), "\n");
    text +=
        concat(curve.boundary ? 1
               : curve.sharp  ? 2
                              : 0,
               curve.sharp ? " # 1=boundary, 0=interior, 2=sharp\n" : " # 1=boundary, 0=interior\n",
               curve.closed ? 1 : 0, " # 1=closed, 0=open\n# number of nodes\n", curve.node_ids.size(), "\n");
    if (!curve.node_ids.empty())
      text += concat("# node indices\n", number_list(curve.node_readings, 1), " # local\n",
                     number_list(curve.node_ids, 0), " # global\n");
    text += concat("# number of datapoints\n", curve.n_readings(), "\n# distance tangent normal\n");
    for (Eigen::Index i = 0; i < curve.n_readings(); ++i) {
      text += exact_decimal(curve.distances[i]);
      for (int k = 0; k < 3; ++k) (text += ' ') += exact_decimal(curve.tangents(i, k));
      for (int k = 0; k < 3; ++k) (text += ' ') += exact_decimal(curve.normals(i, k));
      text += '\n';
    }
  }
  return text;
}

void write_rawnet(const Scan& scan, const std::string& path) {
  write_file(path, format_rawnet(scan));
}

LogScan read_scan(const std::string& path, const LogScanOptions& options, const std::string& columns,
                  NodeNumbers numbers) {
  if (!columns.empty() || is_sensor_log(LineReader(path))) {
    std::vector<std::string> notes;
    const SensorLog log = read_sensor_log(path, columns, &notes);
    return scan_of_log(log, path, options, notes);
  }
  LogScan result;
  result.scan = read_rawnet(path, numbers);
  return result;
}

LogScan parse_scan(std::string text, const std::string& name, const LogScanOptions& options,
                   const std::string& columns, NodeNumbers numbers) {
  if (!columns.empty() || is_sensor_log(LineReader(text, name))) {
    std::vector<std::string> notes;
    const SensorLog log = parse_sensor_log(std::move(text), name, columns, &notes);
    return scan_of_log(log, name, options, notes);
  }
  LogScan result;
  result.scan = parse_rawnet(std::move(text), name, numbers);
  return result;
}

}  // namespace batten
