#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

// Private to the room: JSON as values. The library behind it is included by json.cpp alone.
namespace batten::detail {

/// A JSON value. Lists of nothing but numbers are kept as numbers, 8 bytes each.
class Json {
 public:
  using Numbers = std::vector<double>;
  using List = std::vector<Json>;
  using Object = std::vector<std::pair<std::string, Json>>;

  Json() = default;
  Json(bool value) : value_(value) {}
  Json(int value) : value_(static_cast<double>(value)) {}
  Json(double value) : value_(value) {}
  Json(const char* value) : value_(std::string(value)) {}
  Json(std::string_view value) : value_(std::string(value)) {}
  Json(std::string value) : value_(std::move(value)) {}
  Json(Numbers value) : value_(std::move(value)) {}
  Json(List value) : value_(std::move(value)) {}
  Json(Object value) : value_(std::move(value)) {}

  template <typename T>
  const T* get() const {
    return std::get_if<T>(&value_);
  }
  template <typename T>
  T* get() {
    return std::get_if<T>(&value_);
  }
  bool is_null() const { return value_.index() == 0; }
  bool is_list() const { return get<Numbers>() || get<List>(); }
  /// Entries of a list or an object, else 0.
  std::size_t size() const;
  /// Element i of a list. @pre is_list() and i < size().
  Json at(std::size_t i) const;
  /// The value of a name, the first of it; nothing where there is none or this is no object.
  const Json* find(std::string_view name) const;
  /// Appends a member to an object (null becomes one) and gives its value.
  Json& add(std::string name, Json value);

  /// Equal with numbers bit for bit; lists of numbers equal lists of the same numbers however they are kept.
  bool operator==(const Json& other) const;

 private:
  std::variant<std::monostate, bool, double, std::string, Numbers, List, Object> value_;
};

/// One JSON value. What lies more than 64 levels deep is left out: no field of ours does.
/// @throws InvalidInput when the text is none, or a number is not finite.
Json parse_json(std::string_view text);
bool is_json(std::string_view text);

/// On one line. Numbers read back bit for bit; those that are not finite are the texts "nan", "inf", "-inf".
/// @param indent the members of the outermost object each on a line of their own.
/// @throws InvalidInput naming a text that is not UTF-8.
std::string format_json(const Json& value, bool indent = false);

bool is_utf8(std::string_view text);

}  // namespace batten::detail
