#include "batten/io/log_columns.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

struct Unit {
  LogQuantity quantity;
  const char* name;
  double factor;
};
constexpr Unit kUnits[] = {
    {LogQuantity::Time, "s", 1},
    {LogQuantity::Time, "ms", 1e-3},
    {LogQuantity::Time, "us", 1e-6},
    {LogQuantity::Time, "ns", 1e-9},
    {LogQuantity::Accelerometer, "m/s2", 1},
    {LogQuantity::Accelerometer, "g", kStandardGravity},
    {LogQuantity::Accelerometer, "mg", 1e-3 * kStandardGravity},
    {LogQuantity::Magnetometer, "uT", 1},
    {LogQuantity::Magnetometer, "nT", 1e-3},
    {LogQuantity::Magnetometer, "mT", 1e3},
    {LogQuantity::Magnetometer, "T", 1e6},
    {LogQuantity::Magnetometer, "G", 100},
    {LogQuantity::Magnetometer, "mG", 0.1},
    {LogQuantity::Gyroscope, "rad/s", 1},
    {LogQuantity::Gyroscope, "deg/s", kPi / 180},
    {LogQuantity::Gyroscope, "mdeg/s", 1e-3 * kPi / 180},
};

constexpr const char* kKeys[] = {"time", "curve", "node", "distance", "acc", "mag", "gyr"};
constexpr LogQuantity kQuantities[] = {
    LogQuantity::Time,          LogQuantity::Curve,        LogQuantity::Node,     LogQuantity::Distance,
    LogQuantity::Accelerometer, LogQuantity::Magnetometer, LogQuantity::Gyroscope};

bool is_vector(LogQuantity quantity) {
  return quantity >= LogQuantity::Accelerometer;
}

/// The factor of a unit of one quantity: one of kUnits, a length, or a number with either. Nothing: no such
/// unit.
std::optional<double> factor_of(LogQuantity quantity, std::string_view unit) {
  for (const Unit& each : kUnits)
    if (each.quantity == quantity && unit == each.name) return each.factor;
  if (quantity == LogQuantity::Distance) {
    try {
      const bool has_number =
          !unit.empty() && (std::isdigit(static_cast<unsigned char>(unit[0])) || unit[0] == '.');
      const Length length = parse_length(has_number ? std::string(unit) : concat("1", unit));
      if (length.kind != Length::Kind::Relative && length.value > 0) return length.value;
    } catch (const InvalidInput&) {
      return std::nullopt;
    }
  }
  const std::size_t end = unit.find_first_not_of("0123456789.eE+-");
  double number = 0;
  if (end != std::string_view::npos && end > 0 && parse_number(unit.substr(0, end), number) && number > 0)
    if (const auto factor = factor_of(quantity, unit.substr(end))) return number * *factor;
  return std::nullopt;
}

std::string units_of(LogQuantity quantity) {
  std::string list;
  for (const Unit& unit : kUnits)
    if (unit.quantity == quantity) list += concat(list.empty() ? "" : ", ", unit.name);
  if (quantity == LogQuantity::Distance) return "m, cm, mm, um, in, ft";
  return list.empty() ? "none" : list;
}

constexpr const char* kForm =
    "time=NAME[:UNIT],acc=X:Y:Z[:UNIT],mag=X:Y:Z[:UNIT],gyr=X:Y:Z[:UNIT],distance=NAME[:UNIT],curve=NAME,"
    "node=NAME";

LogFields parse_fields(LogQuantity quantity, std::string_view key, std::string_view value) {
  LogFields fields;
  const std::size_t n = is_vector(quantity) ? 3 : 1;
  const std::vector<std::string_view> parts = split_fields(value, ':');
  const bool counted = quantity == LogQuantity::Curve || quantity == LogQuantity::Node;
  if (parts.size() < n || parts.size() > n + (counted ? 0 : 1))
    throw InvalidInput(concat("'", key, "=", value, "' must name ", n == 3 ? "three columns" : "one column",
                              counted ? "" : " and perhaps a unit", "; the form is ", kForm));
  for (std::size_t k = 0; k < n; ++k) {
    if (parts[k].empty()) throw InvalidInput(concat("'", key, "=", value, "' names a column without a name"));
    fields.names.emplace_back(parts[k]);
  }
  if (parts.size() > n) {
    fields.unit = parts[n];
    const auto factor = factor_of(quantity, fields.unit);
    if (!factor)
      throw InvalidInput(concat("'", fields.unit, "' is no unit of ", key, "; use ", units_of(quantity)));
    fields.factor = *factor;
  }
  return fields;
}

/// A name taken apart: lower case letters and digits in one string, and the unit that stands in brackets or
/// last.
struct Name {
  std::string letters;  ///< "accelerationx" of "Acceleration x (m/s^2)"
  std::string unit;     ///< as kUnits writes it, or as it stands
};

/// A unit as kUnits writes it.
std::string standard_unit(std::string unit) {
  static const std::pair<const char*, const char*> kSpellings[] = {
      {"m/s^2", "m/s2"},  {"m/s²", "m/s2"},     {"m_s2", "m/s2"}, {"mps2", "m/s2"},   {"ms2", "m/s2"},
      {"m/s/s", "m/s2"},  {"°/s", "deg/s"},     {"dps", "deg/s"}, {"deg_s", "deg/s"}, {"degs", "deg/s"},
      {"rad_s", "rad/s"}, {"rads", "rad/s"},    {"rps", "rad/s"}, {"µt", "uT"},       {"μt", "uT"},
      {"ut", "uT"},       {"microtesla", "uT"}, {"nt", "nT"},     {"mt", "mT"},       {"gauss", "G"},
      {"mgauss", "mG"},   {"µs", "us"},         {"μs", "us"},     {"sec", "s"},       {"seconds", "s"},
      {"millis", "ms"},   {"nanoseconds", "ns"}};
  const std::string lower = lower_case(unit);
  for (const auto& [spelling, name] : kSpellings)
    if (lower == spelling) return name;
  return lower == "g" ? "g" : lower;
}

Name taken_apart(const std::string& name) {
  Name parts;
  std::string text = name;
  const std::size_t open = text.find_first_of("([");
  if (open != std::string::npos) {
    const std::size_t close = text.find_first_of(")]", open);
    parts.unit = standard_unit(
        std::string(trim(text.substr(open + 1, close == std::string::npos ? close : close - open - 1))));
    text.erase(open);
  } else {
    for (const char* unit : {"_m_s2", "_mps2", "_rad_s", "_deg_s", "_dps", "_uT", "_ut", "_mG", "_g", "_ms",
                             "_us", "_ns", "_s", "_mm", "_cm", "_m"})
      if (const std::string_view ending(unit);
          text.size() > ending.size() &&
          text.compare(text.size() - ending.size(), ending.size(), ending) == 0) {
        parts.unit = standard_unit(std::string(ending.substr(1)));
        text.erase(text.size() - ending.size());
        break;
      }
  }
  for (const char c : text)
    if (std::isalnum(static_cast<unsigned char>(c))) parts.letters += c;
  parts.letters = lower_case(parts.letters);
  return parts;
}

bool begins_with_one_of(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return text.rfind(word, 0) == 0; });
}

/// The quantity of a vector's component, and which: 0, 1, 2 for x, y, z. Component −1: not one.
std::pair<LogQuantity, int> component_of(std::string letters) {
  for (const char* word : {"imu", "sensor", "raw", "cal", "total"})
    if (letters.rfind(word, 0) == 0) letters.erase(0, std::string_view(word).size());
  if (letters.size() < 2) return {LogQuantity::Time, -1};
  int component = letters.back() - 'x';
  std::string word = letters.substr(0, letters.size() - 1);
  if (component < 0 || component > 2) {  // "xaccel"
    component = letters.front() - 'x';
    word = letters.substr(1);
  }
  if (component < 0 || component > 2) return {LogQuantity::Time, -1};
  if (word == "a" || begins_with_one_of(word, {"acc"})) return {LogQuantity::Accelerometer, component};
  if (word == "m" || begins_with_one_of(word, {"mag"})) return {LogQuantity::Magnetometer, component};
  if (word == "g" || word == "w" ||
      begins_with_one_of(word, {"gyr", "angularvel", "angularrate", "rotationrate"}))
    return {LogQuantity::Gyroscope, component};
  return {LogQuantity::Time, -1};
}

std::optional<LogQuantity> scalar_of(const std::string& letters) {
  if (begins_with_one_of(letters, {"time", "sec", "millis"}) || letters == "t") return LogQuantity::Time;
  if (begins_with_one_of(letters, {"dist", "odo", "ticks", "encoder"})) return LogQuantity::Distance;
  if (letters == "curve" || letters == "curveid" || letters == "line" || letters == "stroke")
    return LogQuantity::Curve;
  if (letters == "node" || letters == "nodeid" || letters == "marker") return LogQuantity::Node;
  return std::nullopt;
}

void set_unit(LogQuantity quantity, const std::string& unit, LogFields& fields) {
  const auto factor = unit.empty() ? std::nullopt : factor_of(quantity, unit);
  fields.unit = factor ? unit : "";
  fields.factor = factor.value_or(1);
}

double median_of(std::vector<double> values) {
  return values.empty() ? std::nan("") : median(values);
}

std::vector<double> lengths_of(const Points& vectors) {
  std::vector<double> lengths;
  for (Eigen::Index i = 0; i < vectors.rows(); ++i)
    if (vectors.row(i).allFinite()) lengths.push_back(vectors.row(i).norm());
  return lengths;
}

double median_step(const SensorLog& log) {
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < log.n_readings(); ++i)
    if (log.time[i] > log.time[i - 1]) steps.push_back(log.time[i] - log.time[i - 1]);
  return median_of(std::move(steps));
}

/// The unit whose factor brings a median nearest to what is usual, by ratio.
std::string nearest_unit(LogQuantity quantity, double value, double usual) {
  std::string best;
  double least = 0;
  for (const Unit& unit : kUnits) {
    if (unit.quantity != quantity) continue;
    const double off = std::abs(std::log(value * unit.factor / usual));
    if (best.empty() || off < least) {
      best = unit.name;
      least = off;
    }
  }
  return best;
}

}  // namespace

LogColumns parse_log_columns(std::string_view text) {
  LogColumns columns;
  for (const std::string_view entry : split_fields(text, ',')) {
    const std::size_t equals = entry.find('=');
    const std::string_view key = trim(entry.substr(0, equals));
    const auto* known = std::find(std::begin(kKeys), std::end(kKeys), key);
    if (equals == std::string_view::npos || known == std::end(kKeys))
      throw InvalidInput(concat("'", entry, "' is no column of a sensor log; the form is ", kForm));
    const LogQuantity quantity = kQuantities[known - std::begin(kKeys)];
    if (columns[quantity]) throw InvalidInput(concat("the columns of ", key, " are given twice"));
    columns[quantity] = parse_fields(quantity, key, trim(entry.substr(equals + 1)));
  }
  if (!columns[LogQuantity::Time]) throw InvalidInput(concat("the columns need a time; the form is ", kForm));
  return columns;
}

std::string format_log_columns(const LogColumns& columns) {
  std::string text;
  for (std::size_t k = 0; k < std::size(kKeys); ++k) {
    const auto& fields = columns[kQuantities[k]];
    if (!fields) continue;
    text += concat(text.empty() ? "" : ",", kKeys[k], "=");
    for (std::size_t i = 0; i < fields->names.size(); ++i)
      text += concat(i == 0 ? "" : ":", fields->names[i]);
    if (!fields->unit.empty()) text += concat(":", fields->unit);
  }
  return text;
}

LogColumns guess_log_columns(const std::vector<std::string>& names) {
  LogColumns columns;
  for (const std::string& name : names) {
    const Name parts = taken_apart(name);
    if (parts.letters.find("linear") != std::string::npos ||
        parts.letters.find("gravity") != std::string::npos)
      continue;
    if (const auto [quantity, component] = component_of(parts.letters); component >= 0) {
      auto& fields = columns[quantity];
      if (!fields) {
        fields.emplace().names.resize(3);
        set_unit(quantity, parts.unit, *fields);
      }
      std::string& place = fields->names[static_cast<std::size_t>(component)];
      if (place.empty()) place = name;
      continue;
    }
    const auto quantity = scalar_of(parts.letters);
    if (!quantity) continue;
    // Of several times the first with a unit is taken: the other one is a date or counts nanoseconds.
    if (columns[*quantity] && !(*quantity == LogQuantity::Time && parts.letters == "secondselapsed"))
      continue;
    columns[*quantity] = LogFields{{name}, {}, 1};
    const bool counted = *quantity == LogQuantity::Curve || *quantity == LogQuantity::Node;
    if (!counted)
      set_unit(*quantity, parts.letters == "secondselapsed" ? "s" : parts.unit, *columns[*quantity]);
  }
  for (auto& fields : columns.fields)
    if (fields && fields->names.size() == 3 &&
        std::any_of(fields->names.begin(), fields->names.end(),
                    [](const std::string& n) { return n.empty(); }))
      fields.reset();
  return columns;
}

void settle_units(LogColumns& columns, SensorLog& log) {
  const auto settle = [&](LogQuantity quantity, double value, double usual, auto scale) {
    auto& fields = columns[quantity];
    if (!fields || !fields->unit.empty() || !(value > 0)) return;
    fields->unit = nearest_unit(quantity, value, usual);
    fields->factor = *factor_of(quantity, fields->unit);
    scale(fields->factor);
  };
  constexpr double kUsualStep = 0.014, kUsualField = 40;  // s, µT: in the middle of 1 … 200 and of 20 … 70
  settle(LogQuantity::Time, median_step(log), kUsualStep, [&](double factor) { log.time *= factor; });
  settle(LogQuantity::Accelerometer, median_of(lengths_of(log.accelerometer)), kStandardGravity,
         [&](double factor) { log.accelerometer *= factor; });
  settle(LogQuantity::Magnetometer, median_of(lengths_of(log.magnetometer)), kUsualField,
         [&](double factor) { log.magnetometer *= factor; });
  // Turns tell little; few hands turn faster than two turns a second, and most sensors give degrees.
  std::vector<double> rates = lengths_of(log.gyroscope);
  auto& gyroscope = columns[LogQuantity::Gyroscope];
  if (gyroscope && gyroscope->unit.empty() && !rates.empty()) {
    gyroscope->unit = *std::max_element(rates.begin(), rates.end()) > 4 * kPi ? "deg/s" : "rad/s";
    gyroscope->factor = *factor_of(LogQuantity::Gyroscope, gyroscope->unit);
    log.gyroscope *= gyroscope->factor;
  }
  auto& distance = columns[LogQuantity::Distance];
  if (distance && distance->unit.empty()) distance->unit = "m";
}

std::vector<std::string> log_oddities(const SensorLog& log) {
  std::vector<std::string> oddities;
  const double acceleration = median_of(lengths_of(log.accelerometer));
  if (acceleration > 0 && (acceleration < 0.8 * kStandardGravity || acceleration > 1.25 * kStandardGravity)) {
    const std::string unit = nearest_unit(LogQuantity::Accelerometer, acceleration, kStandardGravity);
    oddities.push_back(
        concat("the accelerations are ", acceleration, " m/s2 in the middle, where gravity alone is 9.81",
               unit == "m/s2" ? std::string("; calibrate the device (batten calibrate)")
                              : concat("; are they in ", unit, "? Say so with --columns acc=X:Y:Z:", unit)));
  }
  const double step = median_step(log);
  if (step >= 1)
    oddities.push_back(concat("a reading every ", step, " s: the times look like ",
                              step >= 1e5   ? "ns"
                              : step >= 1e3 ? "us"
                                            : "ms",
                              "; say so with --columns time=NAME:",
                              step >= 1e5   ? "ns"
                              : step >= 1e3 ? "us"
                                            : "ms"));
  const double field = median_of(lengths_of(log.magnetometer));
  if (field > 0 && (field < 5 || field > 300)) {
    const std::string unit = nearest_unit(LogQuantity::Magnetometer, field, 40);
    if (unit != "uT")
      oddities.push_back(concat("the magnetic field is ", field,
                                " uT in the middle, where the Earth has 20 to 70; is it in ", unit,
                                "? Say so with --columns mag=X:Y:Z:", unit));
  }
  return oddities;
}

}  // namespace batten
