#include <cmath>
#include <cstdint>
#include <cstring>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/session/json_detail.hpp"

namespace batten::detail {

namespace {

/// 2^53: whole numbers below it are doubles exactly.
constexpr double kWhole = 9007199254740992.0;

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Builds a value from the events of the parser. Without recursion, as nesting has no bound in a text.
class Builder {
 public:
  using number_integer_t = std::int64_t;
  using number_unsigned_t = std::uint64_t;
  using number_float_t = double;
  using string_t = std::string;
  using binary_t = nlohmann::json::binary_t;

  bool null() { return put(Json()); }
  bool boolean(bool value) { return put(Json(value)); }
  bool number_integer(std::int64_t value) { return put_number(static_cast<double>(value)); }
  bool number_unsigned(std::uint64_t value) { return put_number(static_cast<double>(value)); }
  bool number_float(double value, const std::string&) { return put_number(value); }
  bool string(std::string& value) { return put(Json(std::move(value))); }
  bool binary(binary_t&) { return false; }
  bool start_object(std::size_t) { return open(Frame::Kind::Object); }
  bool start_array(std::size_t) { return open(Frame::Kind::List); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    if (too_deep_ == 0) frames_.back().name = std::move(name);
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) { return false; }

  Json take() { return std::move(result_); }

 private:
  struct Frame {
    enum class Kind { Object, List } kind;
    std::string name;
    Json::Object members;
    Json::Numbers numbers;
    Json::List items;
  };
  static constexpr std::size_t kDeepest = 64;

  bool open(Frame::Kind kind) {
    if (too_deep_ > 0 || frames_.size() == kDeepest)
      ++too_deep_;
    else
      frames_.push_back({kind, {}, {}, {}, {}});
    return true;
  }
  bool close() {
    if (too_deep_ > 0) {
      --too_deep_;
      return true;
    }
    Frame frame = std::move(frames_.back());
    frames_.pop_back();
    if (frame.kind == Frame::Kind::Object) return put(Json(std::move(frame.members)));
    return frame.items.empty() ? put(Json(std::move(frame.numbers))) : put(Json(std::move(frame.items)));
  }
  bool put_number(double value) {
    if (too_deep_ > 0 || frames_.empty() || frames_.back().kind == Frame::Kind::Object ||
        !frames_.back().items.empty())
      return put(Json(value));
    frames_.back().numbers.push_back(value);
    return true;
  }
  bool put(Json value) {
    if (too_deep_ > 0) return true;
    if (frames_.empty()) {
      result_ = std::move(value);
      return true;
    }
    Frame& frame = frames_.back();
    if (frame.kind == Frame::Kind::Object) {
      frame.members.emplace_back(std::move(frame.name), std::move(value));
    } else {
      for (const double number : frame.numbers) frame.items.emplace_back(number);
      frame.numbers.clear();
      frame.items.push_back(std::move(value));
    }
    return true;
  }

  std::vector<Frame> frames_;
  std::size_t too_deep_ = 0;
  Json result_;
};

void format_number(double value, std::string& out) {
  if (std::isnan(value))
    out += "\"nan\"";
  else if (std::isinf(value))
    out += value > 0 ? "\"inf\"" : "\"-inf\"";
  else if (value == std::floor(value) && std::abs(value) < kWhole && !(value == 0 && std::signbit(value)))
    out += std::to_string(static_cast<std::int64_t>(value));
  else
    out += nlohmann::json(value).dump();
}

void format_text(const std::string& text, std::string& out) {
  if (!is_utf8(text)) throw InvalidInput("the text \"" + text + "\" is not UTF-8");
  out += nlohmann::json(text).dump();
}

void format(const Json& value, std::string& out, const char* separator) {
  const auto list = [&](const auto& entries, char open, char close, const auto& each) {
    out += open;
    const char* before = *separator ? "\n" : "";
    for (const auto& entry : entries) {
      out += before;
      each(entry);
      before = *separator ? separator : ",";
    }
    if (*separator && !entries.empty()) out += '\n';
    out += close;
  };
  if (value.is_null())
    out += "null";
  else if (const auto* flag = value.get<bool>())
    out += *flag ? "true" : "false";
  else if (const auto* number = value.get<double>())
    format_number(*number, out);
  else if (const auto* text = value.get<std::string>())
    format_text(*text, out);
  else if (const auto* numbers = value.get<Json::Numbers>())
    list(*numbers, '[', ']', [&](double x) { format_number(x, out); });
  else if (const auto* items = value.get<Json::List>())
    list(*items, '[', ']', [&](const Json& item) { format(item, out, ""); });
  else
    list(*value.get<Json::Object>(), '{', '}', [&](const auto& member) {
      format_text(member.first, out);
      out += ':';
      format(member.second, out, "");
    });
}

}  // namespace

std::size_t Json::size() const {
  if (const auto* numbers = get<Numbers>()) return numbers->size();
  if (const auto* items = get<List>()) return items->size();
  if (const auto* members = get<Object>()) return members->size();
  return 0;
}

Json Json::at(std::size_t i) const {
  if (const auto* numbers = get<Numbers>()) return Json((*numbers)[i]);
  return (*get<List>())[i];
}

const Json* Json::find(std::string_view name) const {
  if (const auto* members = get<Object>())
    for (const auto& [key, value] : *members)
      if (key == name) return &value;
  return nullptr;
}

Json& Json::add(std::string name, Json value) {
  if (is_null()) value_ = Object();
  return std::get<Object>(value_).emplace_back(std::move(name), std::move(value)).second;
}

bool Json::operator==(const Json& other) const {
  if (is_list() && other.is_list()) {
    if (size() != other.size()) return false;
    for (std::size_t i = 0; i < size(); ++i)
      if (!(at(i) == other.at(i))) return false;
    return true;
  }
  if (value_.index() != other.value_.index()) return false;
  if (const auto* number = get<double>()) return same_bits(*number, *other.get<double>());
  return value_ == other.value_;
}

Json parse_json(std::string_view text) {
  Builder builder;
  if (!nlohmann::json::sax_parse(text, &builder))
    throw InvalidInput("this is not JSON (numbers must be finite, without NaN)");
  return builder.take();
}

bool is_json(std::string_view text) {
  return nlohmann::json::accept(text);
}

std::string format_json(const Json& value, bool indent) {
  std::string out;
  format(value, out, indent ? ",\n" : "");
  return out;
}

bool is_utf8(std::string_view text) {
  // The library knows: what it would replace is not UTF-8.
  try {
    return !nlohmann::json(text).dump().empty();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

}  // namespace batten::detail
