#include "batten/capture/line_protocol.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
// No sensor has larger numbers in m/s², rad/s or µT.
constexpr double kLargestNumber = 1e6;

/// A field for the eyes of the user: what a stranger sent may be long and hold anything.
std::string shown(std::string_view field) {
  std::string text;
  for (const char c : field.substr(0, 24)) text += c >= ' ' && c <= '~' ? c : '?';
  return concat("'", text, field.size() > 24 ? "…'" : "'");
}

std::uint32_t parse_counter(std::string_view field, const char* what) {
  std::uint64_t value = 0;
  if (field.empty() || field.size() > 10)
    throw InvalidInput(concat("expected ", what, ", found ", shown(field)));
  for (const char c : field) {
    if (c < '0' || c > '9') throw InvalidInput(concat("expected ", what, ", found ", shown(field)));
    value = 10 * value + static_cast<std::uint64_t>(c - '0');
  }
  if (value > std::numeric_limits<std::uint32_t>::max())
    throw InvalidInput(concat(what, " has more than 32 bits: ", shown(field)));
  return static_cast<std::uint32_t>(value);
}

std::optional<std::int32_t> parse_ticks(std::string_view field) {
  if (field.empty()) return std::nullopt;
  long value = 0;
  if (field.size() > 11 || !parse_integer(field, value) || value < std::numeric_limits<std::int32_t>::min() ||
      value > std::numeric_limits<std::int32_t>::max())
    throw InvalidInput(concat("expected ticks, a whole number of 32 bits, found ", shown(field)));
  return static_cast<std::int32_t>(value);
}

double parse_value(std::string_view field, const char* what) {
  double value = 0;
  if (field.empty()) return kMissing;
  if (!parse_number(field, value) || !(std::abs(value) <= kLargestNumber))
    throw InvalidInput(concat("expected ", what, ", found ", shown(field)));
  return value;
}

Eigen::Vector3d parse_vector(const std::vector<std::string_view>& fields, std::size_t first,
                             const char* what) {
  Eigen::Vector3d v;
  for (std::size_t k = 0; k < 3; ++k) v[static_cast<Eigen::Index>(k)] = parse_value(fields[first + k], what);
  if (!v.allFinite()) v.setConstant(kMissing);  // a vector is whole or not there
  return v;
}

void expect_fields(const std::vector<std::string_view>& fields, std::size_t n) {
  if (fields.size() != n)
    throw InvalidInput(concat("expected ", n, " fields after ", fields[0], ", found ", fields.size()));
}

std::optional<DeviceAxes> parse_axes(std::string_view text) {
  const std::vector<std::string_view> words = split_fields(text, ',');
  if (words.size() != 2) return std::nullopt;
  DeviceAxes axes;
  for (std::size_t i = 0; i < 2; ++i) {
    std::string_view word = words[i];
    double sign = 1;
    if (!word.empty() && (word[0] == '+' || word[0] == '-')) {
      sign = word[0] == '-' ? -1 : 1;
      word.remove_prefix(1);
    }
    if (word != "x" && word != "y" && word != "z") return std::nullopt;
    Eigen::Vector3d& axis = i == 0 ? axes.forward : axes.normal;
    axis.setZero();
    axis[word[0] - 'x'] = sign;
  }
  if (axes.forward.dot(axes.normal) != 0) return std::nullopt;
  return axes;
}

DeviceHeader parse_header(std::string_view line) {
  const std::vector<std::string_view> words = split_blanks(line);
  long version = 0;
  if (words.size() < 2 || words[0] != "#batten" || !parse_integer(words[1], version) || version < 1)
    throw InvalidInput(concat("expected a header like #batten 1 device=NAME …, found ", shown(line)));
  if (version > 1)
    throw InvalidInput(concat("the device speaks version ", version,
                              " of the line protocol, this program version 1; take a newer batten"));
  DeviceHeader header;
  for (std::size_t i = 2; i < words.size(); ++i) {
    const std::size_t equals = std::min(words[i].find('='), words[i].size());
    const std::string_view key = words[i].substr(0, equals);
    const std::string_view value = equals < words[i].size() ? words[i].substr(equals + 1) : "";
    const auto number = [&](double low, double high) {
      double result = 0;
      if (!parse_number(value, result) || !(result >= low && result <= high))
        throw InvalidInput(concat("the header of the device has ", shown(words[i]),
                                  "; expected a number from ", low, " to ", high));
      return result;
    };
    if (key == "device") {
      header.device = value;
    } else if (key == "axes") {
      header.axes = parse_axes(value);
      if (!header.axes)
        throw InvalidInput(concat("the header of the device has ", shown(words[i]),
                                  "; expected axes like +x,+z (forward and normal, at right angles)"));
    } else if (key == "ticks_per_m") {
      header.ticks_per_m = number(0, 1e9);
    } else if (key == "rate_hz") {
      header.rate_hz = number(0, 1e5);
    } else if (key == "wheel_offset_m") {
      header.wheel_offset_m = number(-1, 1);
    } else if (key == "check") {
      header.checked = value != "none";
    } else if (key == "quat" && value != "wxyz") {
      throw InvalidInput("the device sends quaternions in another order; quat=wxyz is understood");
    }
  }
  return header;
}

/// What samples and presses of buttons begin with.
template <typename Message>
Message parse_head(const std::vector<std::string_view>& fields, std::size_t n_fields) {
  expect_fields(fields, n_fields);
  Message message;
  message.seq = parse_counter(fields[1], "a running number");
  message.t_us = parse_counter(fields[2], "a time in microseconds");
  return message;
}

LineMessage parse_sample(const std::vector<std::string_view>& fields) {
  RawSample sample = parse_head<RawSample>(fields, 13);
  sample.ticks = parse_ticks(fields[3]);
  sample.accelerometer = parse_vector(fields, 4, "an acceleration");
  sample.gyroscope = parse_vector(fields, 7, "an angular rate");
  sample.magnetometer = parse_vector(fields, 10, "a magnetic field");
  return sample;
}

LineMessage parse_fused(const std::vector<std::string_view>& fields) {
  FusedSample sample = parse_head<FusedSample>(fields, 9);
  sample.ticks = parse_ticks(fields[3]);
  Eigen::Vector4d q;
  for (std::size_t k = 0; k < 4; ++k)
    q[static_cast<Eigen::Index>(k)] = parse_value(fields[4 + k], "a part of a quaternion");
  const double norm = q.norm();
  if (!(norm > 0.9 && norm < 1.1)) throw InvalidInput("the quaternion is not of length 1");
  q /= norm;
  sample.orientation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  sample.accuracy_rad = parse_value(fields[8], "an accuracy");
  return sample;
}

LineMessage parse_button(const std::vector<std::string_view>& fields) {
  ButtonPress press = parse_head<ButtonPress>(fields, 4);
  press.key = fields[3];
  if (press.key.empty() || press.key.size() > 32) throw InvalidInput("expected the name of a key");
  for (const char c : press.key)
    if ((c < 'a' || c > 'z') && (c < '0' || c > '9') && c != '=')
      throw InvalidInput(concat("expected the name of a key, found ", shown(press.key)));
  return press;
}

std::string six_digits(double value) {
  if (std::isnan(value)) return {};
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string with_check(std::string body) {
  char check[8];
  std::snprintf(check, sizeof check, "*%02X", line_check(body));
  return body + check;
}

struct Formatter {
  static std::string counted(char kind, std::uint32_t seq, std::uint32_t t_us) {
    return concat(kind, ",", seq, ",", t_us, ",");
  }
  static std::string axis(const Eigen::Vector3d& a) {
    Eigen::Index k = 0;
    a.cwiseAbs().maxCoeff(&k);
    return concat(a[k] < 0 ? '-' : '+', "xyz"[k]);
  }

  std::string operator()(const DeviceHeader& h) const {
    std::string line = concat("#batten 1 device=", h.device);
    if (h.axes) line += concat(" axes=", axis(h.axes->forward), ",", axis(h.axes->normal));
    if (h.ticks_per_m > 0) line += concat(" ticks_per_m=", exact_decimal(h.ticks_per_m));
    if (h.rate_hz > 0) line += concat(" rate_hz=", exact_decimal(h.rate_hz));
    if (h.wheel_offset_m != 0) line += concat(" wheel_offset_m=", exact_decimal(h.wheel_offset_m));
    return line + (h.checked ? " quat=wxyz" : " quat=wxyz check=none");
  }
  std::string operator()(const RawSample& s) const {
    std::string body = counted('S', s.seq, s.t_us);
    if (s.ticks) body += std::to_string(*s.ticks);
    for (const Eigen::Vector3d* v : {&s.accelerometer, &s.gyroscope, &s.magnetometer})
      for (const double x : *v) body += "," + six_digits(x);
    return with_check(body);
  }
  std::string operator()(const FusedSample& s) const {
    std::string body = counted('Q', s.seq, s.t_us);
    if (s.ticks) body += std::to_string(*s.ticks);
    const Eigen::Quaterniond& q = s.orientation;
    for (const double x : {q.w(), q.x(), q.y(), q.z(), s.accuracy_rad}) body += "," + six_digits(x);
    return with_check(body);
  }
  std::string operator()(const ButtonPress& p) const {
    return with_check(counted('K', p.seq, p.t_us) + p.key);
  }
  std::string operator()(const DeviceComplaint& c) const { return with_check("E," + c.text); }
};

}  // namespace

unsigned line_check(std::string_view body) {
  unsigned check = 0;
  for (const char c : body) check ^= static_cast<unsigned char>(c);
  return check;
}

LineMessage parse_line(std::string_view line, bool checked) {
  line = trim(line);
  if (line.empty()) throw InvalidInput("the line is empty");
  if (line.size() > kLongestLine)
    throw InvalidInput(concat("the line is longer than ", kLongestLine, " characters"));
  if (line.front() == '#') return parse_header(line);
  std::string_view body = line;
  const std::size_t star = line.rfind('*');
  if (star != std::string_view::npos && star + 3 == line.size()) {
    body = line.substr(0, star);
    char expected[8];
    std::snprintf(expected, sizeof expected, "%02X", line_check(body));
    if (lower_case(line.substr(star + 1)) != lower_case(expected))
      throw InvalidInput(
          concat("the check of the line is ", shown(line.substr(star + 1)), ", expected ", expected));
  } else if (checked) {
    throw InvalidInput(
        "the line has no check *HH at its end; a device without says check=none in its header");
  }
  if (body.substr(0, 2) == "E,") return DeviceComplaint{std::string(body.substr(2))};
  const std::vector<std::string_view> fields = split_fields(body, ',');
  if (fields[0] == "S") return parse_sample(fields);
  if (fields[0] == "Q") return parse_fused(fields);
  if (fields[0] == "K") return parse_button(fields);
  throw InvalidInput(concat("a line begins with S, Q, K, E or #, not with ", shown(fields[0])));
}

std::string format_line(const LineMessage& message) {
  return std::visit(Formatter{}, message);
}

std::vector<std::string> LineSplitter::push(std::string_view bytes) {
  std::vector<std::string> lines;
  const auto give_out = [&] {
    if (!rest_.empty() && rest_.back() == '\r') rest_.pop_back();
    if (!rest_.empty()) lines.push_back(std::move(rest_));
    rest_.clear();
  };
  for (const char c : bytes) {
    if (c == '\n') {
      give_out();
      continue;
    }
    rest_ += c;
    if (rest_.size() == kLongestLine) give_out();
  }
  return lines;
}

}  // namespace batten
