#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/json_fields_detail.hpp"

namespace batten::detail {

namespace {

bool to_number(const Json& value, double& number) {
  if (const auto* plain = value.get<double>()) {
    number = *plain;
    return true;
  }
  const auto* text = value.get<std::string>();
  if (!text) return false;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (*text == "nan")
    number = std::numeric_limits<double>::quiet_NaN();
  else if (*text == "inf" || *text == "-inf")
    number = (*text)[0] == '-' ? -kInfinity : kInfinity;
  else
    return false;
  return true;
}

}  // namespace

std::string shown(const Json& value) {
  constexpr std::size_t kMostShown = 8;
  if (value.get<Json::Object>()) return "an object";
  const auto* items = value.get<Json::List>();
  const auto is_nested = [](const Json& x) { return x.is_list() || x.get<Json::Object>(); };
  if (value.size() > kMostShown || (items && std::any_of(items->begin(), items->end(), is_nested)))
    return concat("a list of ", value.size());
  constexpr std::size_t kLongest = 200, kLongestText = 60;
  return format_json(value).substr(0, value.is_list() ? kLongest : kLongestText);
}

Fields::Fields(const Json& object, std::string what) : object_(object), what_(std::move(what)) {
  if (!object.get<Json::Object>()) throw InvalidInput(concat(what_, " must be a JSON object"));
}

Fields::Fields(const Json& object, std::string what, const std::vector<std::string>& known)
    : Fields(object, std::move(what)) {
  refuse_others(known);
}

void Fields::refuse_others(const std::vector<std::string>& known) const {
  for (const auto& [name, value] : *object_.get<Json::Object>()) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string list;
    for (const std::string& other : known) list += (list.empty() ? "" : ", ") + other;
    throw InvalidInput(concat(what_, " has no field \"", name, "\"; it takes ", list));
  }
}

const Json& Fields::require(std::string_view name) const {
  const Json* value = find(name);
  if (!value) throw InvalidInput(concat(what_, " needs the field \"", name, "\""));
  return *value;
}

void Fields::fail(std::string_view name, std::string_view expected) const {
  throw InvalidInput(concat("the field \"", name, "\" of ", what_, " must be ", expected));
}

double Fields::number(std::string_view name, double otherwise) const {
  const Json* value = find(name);
  return value ? number_of(*value, name) : otherwise;
}

double Fields::number_of(const Json& value, std::string_view name) const {
  double number = 0;
  if (!to_number(value, number)) fail(name, "a number");
  return number;
}

int Fields::integer_of(const Json& value, std::string_view name) const {
  const double number = number_of(value, name);
  if (!(number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max()) ||
      number != std::floor(number))
    fail(name, "a whole number");
  return static_cast<int>(number);
}

bool Fields::flag(std::string_view name) const {
  const Json* value = find(name);
  return value && flag_of(*value, name);
}

bool Fields::flag_of(const Json& value, std::string_view name) const {
  const auto* flag = value.get<bool>();
  if (!flag) fail(name, "true or false");
  return *flag;
}

const std::string& Fields::text_of(const Json& value, std::string_view name) const {
  const auto* text = value.get<std::string>();
  if (!text) fail(name, "a text");
  return *text;
}

int Fields::id_of(const Json& value, std::string_view name, char kind, std::string_view expected) const {
  const auto* text = value.get<std::string>();
  constexpr long kLargest = std::numeric_limits<int>::max() - 1;
  long number = -1;
  if (!text || text->size() < 2 || (*text)[0] != kind ||
      !parse_integer(std::string_view(*text).substr(1), number) || number < 0 || number > kLargest)
    fail(name, expected);
  return static_cast<int>(number);
}

int Fields::curve(const Json& value, std::string_view name) const {
  return id_of(value, name, 'c', "the id of a curve, such as \"c3\"");
}

int Fields::vertex(const Json& value, std::string_view name) const {
  return id_of(value, name, 'v', "the ids of vertices, such as [\"v3\", \"v5\"]");
}

Points Fields::points(const Json& value, std::string_view name) const {
  if (!value.is_list()) fail(name, "a list of points [x, y, z]");
  Points points(static_cast<Eigen::Index>(value.size()), 3);
  for (std::size_t i = 0; i < value.size(); ++i) {
    const Json point = value.at(i);
    const auto* coordinates = point.get<Json::Numbers>();
    if (!coordinates || coordinates->size() != 3)
      fail(name, concat("a list of points [x, y, z]; point ", i, " is ", shown(point)));
    for (std::size_t k = 0; k < 3; ++k)
      points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = (*coordinates)[k];
  }
  return points;
}

std::vector<double> Fields::numbers(const Json& value, std::string_view name) const {
  if (const auto* plain = value.get<Json::Numbers>()) return *plain;
  const auto* items = value.get<Json::List>();
  if (!items) fail(name, "a list of numbers");
  std::vector<double> numbers(items->size());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!to_number((*items)[i], numbers[i])) fail(name, concat("a list of numbers; entry ", i, " is none"));
  return numbers;
}

std::vector<int> Fields::integers(const Json& value, std::string_view name) const {
  const auto* numbers = value.get<Json::Numbers>();
  if (!numbers) fail(name, "a list of whole numbers");
  std::vector<int> integers(numbers->size());
  for (std::size_t i = 0; i < integers.size(); ++i) integers[i] = integer_of(Json((*numbers)[i]), name);
  return integers;
}

Points Fields::rows(const Json& value, std::string_view name) const {
  const std::vector<double> flat = numbers(value, name);
  if (flat.size() % 3 != 0) fail(name, concat("a list of 3 n numbers, there are ", flat.size()));
  return Eigen::Map<const Points>(flat.data(), static_cast<Eigen::Index>(flat.size() / 3), 3);
}

Eigen::Vector3d Fields::vector(const Json& value, std::string_view name) const {
  const std::vector<double> flat = numbers(value, name);
  if (flat.size() != 3) fail(name, "a list of three numbers");
  return {flat[0], flat[1], flat[2]};
}

Json list_of_points(const Points& points) {
  Json::List list;
  list.reserve(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    list.emplace_back(Json::Numbers{points(i, 0), points(i, 1), points(i, 2)});
  return list;
}

Json flat_list(const Points& rows) {
  return Json::Numbers(rows.data(), rows.data() + rows.size());
}

Json flat_list(const Eigen::VectorXd& values) {
  return Json::Numbers(values.data(), values.data() + values.size());
}

Json flat_list(const std::vector<int>& values) {
  return Json::Numbers(values.begin(), values.end());
}

Json flat_list(const Eigen::Vector3d& vector) {
  return Json::Numbers{vector.x(), vector.y(), vector.z()};
}

std::string id_text(char kind, int number) {
  return kind + std::to_string(number);
}

}  // namespace batten::detail
