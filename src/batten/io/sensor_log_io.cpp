#include "batten/io/sensor_log_io.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/log_columns.hpp"
#include "batten/io/scan_text_detail.hpp"

namespace batten {

namespace {

using detail::one_line;
using detail::quoted;

enum Column {
  kTime,
  kCurve,
  kNode,
  kDistance,
  kAccelerometer,
  kMagnetometer = kAccelerometer + 3,
  kGyroscope = kMagnetometer + 3,
  kColumns = kGyroscope + 3
};

constexpr std::array<const char*, kColumns> kColumnNames = {
    "time_s",   "curve",    "node",     "distance_m",  "acc_x_m_s2",  "acc_y_m_s2", "acc_z_m_s2",
    "mag_x_uT", "mag_y_uT", "mag_z_uT", "gyr_x_rad_s", "gyr_y_rad_s", "gyr_z_rad_s"};

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

std::string_view without_quotes(std::string_view cell) {
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') return cell.substr(1, cell.size() - 2);
  return cell;
}

/// The names with commas between.
template <typename Names>
std::string in_a_row(const Names& names) {
  std::string row;
  for (const auto& name : names) row += concat(row.empty() ? "" : ", ", name);
  return row;
}

/// "+x", "-z", "y": an axis of the device.
bool parse_axis(std::string_view text, Eigen::Vector3d& axis) {
  double sign = 1;
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    sign = text.front() == '-' ? -1 : 1;
    text.remove_prefix(1);
  }
  if (text != "x" && text != "y" && text != "z") return false;
  axis = Eigen::Vector3d::Zero();
  axis[text.front() - 'x'] = sign;
  return true;
}

std::string axis_text(const Eigen::Vector3d& axis) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) == 1) return concat(axis[k] < 0 ? '-' : '+', "xyz"[k]);
  throw InvalidInput("the axes of a device must run along its coordinate axes to be written to a log");
}

class LogParser {
 public:
  /// @param columns what fields hold what: nothing for the names of SensorLog, "auto", or a description.
  LogParser(LineReader& in, std::string columns, std::vector<std::string>* notes)
      : in_(in), description_(std::move(columns)), notes_(notes) {}

  SensorLog parse() {
    std::string_view line;
    while (in_.next(line)) {
      line = trim(line);
      if (line.empty()) continue;
      if (line.front() == '#')
        understand_comment(trim(line.substr(1)));
      else if (!has_header_)
        parse_header(line);
      else
        parse_row(line);
    }
    if (!has_header_)
      throw FileError(
          in_.path(), 0,
          "the file has no line with the names of its columns; expected time_s,curve,node,distance_m,…");
    if (n_rows_ == 0) throw FileError(in_.path(), 0, "the log has no readings; record some");
    log_.resize(n_rows_);
    detail::check_node_numbers(nodes_);
    if (description_ == "auto") {
      settle_units(*chosen_, log_);
      note(concat("the columns were read as ", format_log_columns(*chosen_),
                  "; where that is wrong, give --columns as it should be"));
    }
    if (whole_is_one_curve_) note("the log names no curves: all of it was taken for one");
    if (notes_ != nullptr) {
      const std::vector<std::string> oddities = log_oddities(log_);
      notes_->insert(notes_->end(), oddities.begin(), oddities.end());
    }
    return std::move(log_);
  }

 private:
  void understand_comment(std::string_view comment) {
    if (comment.substr(0, 5) == "axes:") {
      parse_axes(comment.substr(5));
    } else if (comment.substr(0, 6) == "curve " && comment.find(':') != std::string_view::npos) {
      const size_t colon = comment.find(':');
      parse_curve_line(trim(comment.substr(6, colon - 6)), trim(comment.substr(colon + 1)));
    }
  }

  void parse_axes(std::string_view text) {
    for (const std::string_view word : split_blanks(text)) {
      const size_t equals = word.find('=');
      const std::string_view key = word.substr(0, equals);
      const std::string_view value = equals == std::string_view::npos ? "" : word.substr(equals + 1);
      Eigen::Vector3d axis;
      if ((key != "forward" && key != "normal") || !parse_axis(value, axis))
        in_.fail(concat("expected device axes like forward=+x normal=+z, found ", quoted(word)));
      (key == "forward" ? log_.axes.forward : log_.axes.normal) = axis;
    }
    if (log_.axes.forward.dot(log_.axes.normal) != 0)
      in_.fail("forward and normal are along the same axis of the device; they must be at right angles");
  }

  void parse_curve_line(std::string_view number_text, std::string_view words) {
    long number = 0;
    if (!parse_integer(number_text, number) || number < 0 || number > std::numeric_limits<int>::max())
      in_.fail(concat("expected the number of a curve, found ", quoted(number_text)));
    LogCurve flags;
    flags.number = static_cast<int>(number);
    while (!words.empty()) {
      if (words.substr(0, 5) == "name=") {  // to the end of the line
        flags.name = words.substr(5);
        break;
      }
      const size_t end = std::min(words.find_first_of(" \t"), words.size());
      const std::string_view word = words.substr(0, end);
      if (word == "boundary")
        flags.boundary = true;
      else if (word == "sharp")
        flags.sharp = true;
      else if (word == "closed")
        flags.closed = true;
      else if (word != "interior" && word != "open")
        in_.fail(concat("expected boundary, interior, sharp, closed, open or name=… for a curve, found ",
                        quoted(word)));
      words = trim(words.substr(end));
    }
    const auto known = index_of_curve_.find(flags.number);
    if (known != index_of_curve_.end())
      log_.curves[static_cast<size_t>(known->second)] = flags;
    else
      flags_of_curve_[flags.number] = flags;
  }

  void note(std::string_view sentence) const {
    if (notes_ != nullptr) notes_->emplace_back(sentence);
  }

  void parse_header(std::string_view line) {
    for (const char candidate : {';', '\t'})
      if (std::count(line.begin(), line.end(), candidate) > std::count(line.begin(), line.end(), separator_))
        separator_ = candidate;
    std::vector<std::string> names;
    for (const std::string_view field : split_fields(line, separator_))
      names.emplace_back(trim(without_quotes(trim(field))));
    columns_.assign(names.size(), -1);
    factors_.fill(1);
    if (description_.empty())
      take_own_columns(names);
    else
      take_described_columns(names);
    has_header_ = true;
  }

  void take_own_columns(const std::vector<std::string>& names) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto* name = std::find(kColumnNames.begin(), kColumnNames.end(), names[k]);
      if (name == kColumnNames.end()) continue;
      const int column = static_cast<int>(name - kColumnNames.begin());
      if (std::count(columns_.begin(), columns_.end(), column) > 0)
        in_.fail(concat("the column ", *name, " is named twice"));
      columns_[k] = column;
    }
    if (std::count(columns_.begin(), columns_.end(), static_cast<int>(kTime)) > 0) return;
    const LogColumns guess = guess_log_columns(names);
    const bool guessed = guess[LogQuantity::Time] && guess[LogQuantity::Accelerometer];
    in_.fail(concat("expected the names of the columns, time_s among them (of ", in_a_row(kColumnNames),
                    "), found ", in_a_row(names), "; ",
                    guessed
                        ? concat("try --columns auto, which reads ", format_log_columns(guess))
                        : std::string("say what they hold with --columns time=NAME:UNIT,acc=X:Y:Z:UNIT,…")));
  }

  void take_described_columns(const std::vector<std::string>& names) {
    chosen_ = description_ == "auto" ? guess_log_columns(names) : parse_log_columns(description_);
    if (description_ == "auto" &&
        (!(*chosen_)[LogQuantity::Time] || !(*chosen_)[LogQuantity::Accelerometer])) {
      in_.fail(concat("no time and acceleration were recognised among the columns ", in_a_row(names),
                      "; name them with --columns time=NAME:UNIT,acc=X:Y:Z:UNIT,…"));
    }
    const auto take = [&](LogQuantity quantity, int first) {
      const auto& fields = (*chosen_)[quantity];
      if (!fields) return;
      for (std::size_t i = 0; i < fields->names.size(); ++i) {
        const auto place = std::find(names.begin(), names.end(), fields->names[i]);
        if (place == names.end()) {
          in_.fail(
              concat("there is no column ", quoted(fields->names[i]), "; the columns are ", in_a_row(names)));
        }
        columns_[static_cast<std::size_t>(place - names.begin())] = first + static_cast<int>(i);
        factors_[static_cast<std::size_t>(first) + i] = fields->factor;
      }
    };
    take(LogQuantity::Time, kTime);
    take(LogQuantity::Curve, kCurve);
    take(LogQuantity::Node, kNode);
    take(LogQuantity::Distance, kDistance);
    take(LogQuantity::Accelerometer, kAccelerometer);
    take(LogQuantity::Magnetometer, kMagnetometer);
    take(LogQuantity::Gyroscope, kGyroscope);
    whole_is_one_curve_ = !(*chosen_)[LogQuantity::Curve];
  }

  /// A cell as a number; where columns are not separated by commas, a comma may stand for the point.
  bool parse_cell(std::string_view cell, double& value) const {
    if (parse_number(cell, value)) return !std::isinf(value);
    if (separator_ == ',' || cell.find(',') == std::string_view::npos) return false;
    std::string pointed(cell);
    std::replace(pointed.begin(), pointed.end(), ',', '.');
    return parse_number(pointed, value) && !std::isinf(value);
  }

  void parse_row(std::string_view line) {
    std::array<double, kColumns> values;
    values.fill(kMissing);
    std::string_view rest = line;
    for (size_t k = 0; k < columns_.size(); ++k) {
      const size_t end = rest.find(separator_);
      if ((end == std::string_view::npos) != (k + 1 == columns_.size()))
        in_.fail(concat("expected ", columns_.size(), " cells as the first line names, found ",
                        1 + std::count(line.begin(), line.end(), separator_)));
      const std::string_view cell = without_quotes(trim(rest.substr(0, end)));
      if (end != std::string_view::npos) rest.remove_prefix(end + 1);
      if (columns_[k] < 0 || cell.empty()) continue;
      const auto column = static_cast<size_t>(columns_[k]);
      if (!parse_cell(cell, values[column]))
        in_.fail(concat("expected a number for ", kColumnNames[column], ", found ", quoted(cell)));
      values[column] *= factors_[column];
    }
    if (whole_is_one_curve_) values[kCurve] = 1;
    append(values);
  }

  int whole(double value, const char* what) const {
    if (std::isnan(value)) return SensorLog::kNone;
    if (value != std::floor(value) || value < 0 || value > std::numeric_limits<int>::max())
      in_.fail(concat(what, " must be a whole number from 0, got ", value));
    return static_cast<int>(value);
  }

  void append(const std::array<double, kColumns>& values) {
    if (n_rows_ == log_.n_readings()) log_.resize(std::max<Eigen::Index>(1024, 2 * n_rows_));
    const Eigen::Index row = n_rows_;
    const auto at = static_cast<size_t>(row);
    const double time = values[kTime];
    if (std::isnan(time)) in_.fail("the reading has no time; fill the column time_s");
    const int number = whole(values[kCurve], "the number of the curve");
    log_.curve[at] = number == SensorLog::kNone ? SensorLog::kNone : curve_index(number);
    log_.node[at] = whole(values[kNode], "the number of the node");
    if (log_.node[at] != SensorLog::kNone) {
      if (log_.curve[at] == SensorLog::kNone) in_.fail("a node needs a curve; fill the column curve");
      nodes_.push_back({log_.node[at], in_.path(), in_.line_number()});
    }
    log_.time[row] = time;
    log_.distance[row] = values[kDistance];
    for (int k = 0; k < 3; ++k) {
      log_.accelerometer(row, k) = values[size_t{kAccelerometer} + static_cast<size_t>(k)];
      log_.magnetometer(row, k) = values[size_t{kMagnetometer} + static_cast<size_t>(k)];
      log_.gyroscope(row, k) = values[size_t{kGyroscope} + static_cast<size_t>(k)];
    }
    check_order(row);
    ++n_rows_;
  }

  int curve_index(int number) {
    const auto [place, is_new] = index_of_curve_.emplace(number, static_cast<int>(log_.curves.size()));
    if (is_new) {
      const auto flags = flags_of_curve_.find(number);
      LogCurve curve;
      curve.number = number;
      log_.curves.push_back(flags == flags_of_curve_.end() ? curve : flags->second);
    } else if (place->second != static_cast<int>(log_.curves.size()) - 1) {
      in_.fail(concat("curve ", number, " is taken up again after curve ", log_.curves.back().number,
                      "; give the second part a number of its own"));
    }
    return place->second;
  }

  /// Within a curve neither time nor distance may run backwards.
  void check_order(Eigen::Index row) {
    const int curve = log_.curve[static_cast<size_t>(row)];
    if (curve == SensorLog::kNone) return;
    const int number = log_.curves[static_cast<size_t>(curve)].number;
    if (curve == last_curve_ && log_.time[row] < last_time_)
      in_.fail(concat("the time falls from ", last_time_, " to ", log_.time[row], " on curve ", number,
                      "; sort the rows by time"));
    if (curve == last_curve_ && log_.distance[row] < last_distance_)
      in_.fail(concat("the distance falls from ", last_distance_, " to ", log_.distance[row], " on curve ",
                      number, "; distances must not decrease along a curve"));
    last_distance_ = log_.distance[row];
    last_time_ = log_.time[row];
    last_curve_ = curve;
  }

  LineReader& in_;
  std::string description_;
  std::vector<std::string>* notes_;
  char separator_ = ',';
  std::optional<LogColumns> chosen_;  // where they are not our own
  std::array<double, kColumns> factors_{};
  bool whole_is_one_curve_ = false;
  SensorLog log_;
  Eigen::Index n_rows_ = 0;
  bool has_header_ = false;
  std::vector<int> columns_;  // per field of the file: a Column, or −1
  std::map<int, LogCurve> flags_of_curve_;
  std::map<int, int> index_of_curve_;
  std::vector<detail::NodeEntry> nodes_;
  int last_curve_ = SensorLog::kNone;
  double last_time_ = 0;
  double last_distance_ = 0;
};

std::string cell(double value) {
  return std::isnan(value) ? std::string() : exact_decimal(value);
}

}  // namespace

SensorLog read_sensor_log(const std::string& path, const std::string& columns,
                          std::vector<std::string>* notes) {
  LineReader in(path);
  return LogParser(in, columns, notes).parse();
}

SensorLog parse_sensor_log(std::string text, const std::string& name, const std::string& columns,
                           std::vector<std::string>* notes) {
  LineReader in(std::move(text), name);
  return LogParser(in, columns, notes).parse();
}

void write_sensor_log(const SensorLog& log, const std::string& path) {
  std::string text = concat("# sensor log\n# axes: forward=", axis_text(log.axes.forward),
                            " normal=", axis_text(log.axes.normal), "\n");
  for (const LogCurve& curve : log.curves) {
    text += concat("# curve ", curve.number, ":",
                   curve.boundary ? " boundary"
                   : curve.sharp  ? " sharp"
                                  : " interior",
                   curve.closed ? " closed" : " open");
    if (!curve.name.empty()) text += concat(" name=", one_line(curve.name));
    text += '\n';
  }
  for (size_t k = 0; k < kColumnNames.size(); ++k) text += concat(k == 0 ? "" : ",", kColumnNames[k]);
  text += '\n';
  OutputFile out(path);
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const int curve = log.curve[static_cast<size_t>(i)];
    const int node = log.node[static_cast<size_t>(i)];
    text += cell(log.time[i]);
    text += ',';
    if (curve != SensorLog::kNone) text += std::to_string(log.curves[static_cast<size_t>(curve)].number);
    text += ',';
    if (node != SensorLog::kNone) text += std::to_string(node);
    (text += ',') += cell(log.distance[i]);
    for (const Points* sensor : {&log.accelerometer, &log.magnetometer, &log.gyroscope})
      for (int k = 0; k < 3; ++k) (text += ',') += cell((*sensor)(i, k));
    text += '\n';
    if (text.size() > size_t{1} << 20) {
      out.write(text);
      text.clear();
    }
  }
  out.write(text);
  out.commit();
}

}  // namespace batten
