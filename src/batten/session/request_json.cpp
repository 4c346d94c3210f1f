#include <type_traits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/json_fields_detail.hpp"
#include "batten/session/request_fields_detail.hpp"
#include "batten/session/request_json_detail.hpp"

namespace batten::detail {

namespace {

template <typename T>
constexpr bool kIsOptional = false;
template <typename T>
constexpr bool kIsOptional<std::optional<T>> = true;
template <typename T>
constexpr bool kIsShared = false;
template <typename T>
constexpr bool kIsShared<std::shared_ptr<const T>> = true;
template <typename T>
constexpr bool kIsVector = false;
template <typename T>
constexpr bool kIsVector<std::vector<T>> = true;

class Writer {
 public:
  template <typename T>
  void operator()(const char* name, T& value) {
    object_.add(name, json(value));
  }
  Json take() { return std::move(object_); }

  template <typename T>
  static Json json(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      return Json(value);
    } else if constexpr (std::is_enum_v<T>) {
      return Json(choices_of(value).word(value));
    } else if constexpr (std::is_arithmetic_v<T>) {
      return Json(static_cast<double>(value));
    } else if constexpr (std::is_same_v<T, std::string>) {
      return Json(value);
    } else if constexpr (kIsOptional<T>) {
      return value ? json(*value) : Json();
    } else if constexpr (kIsShared<T>) {
      return value ? flat_list(*value) : Json();
    } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
      return flat_list(value);
    } else if constexpr (kIsVector<T>) {
      Json::List list;
      for (auto& entry : value) list.push_back(json(entry));
      return list;
    } else {
      Writer writer;
      visit_fields(value, writer);
      return writer.take();
    }
  }

 private:
  Json object_ = Json::Object();
};

class Reader {
 public:
  Reader(const Json& object, const std::string& what) : fields_(object, what) {}

  template <typename T>
  void operator()(const char* name, T& value) {
    known_.emplace_back(name);
    if (const Json* json = fields_.find(name)) read(*json, name, value);
  }
  void finish() const { fields_.refuse_others(known_); }
  void know(const char* name) { known_.emplace_back(name); }

 private:
  template <typename T>
  void read(const Json& json, const char* name, T& value) const {
    if constexpr (std::is_same_v<T, bool>) {
      value = fields_.flag_of(json, name);
    } else if constexpr (std::is_enum_v<T>) {
      value = word(json, name, choices_of(value));
    } else if constexpr (std::is_floating_point_v<T>) {
      value = fields_.number_of(json, name);
    } else if constexpr (std::is_arithmetic_v<T>) {
      value = fields_.integer_of(json, name);
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = fields_.text_of(json, name);
    } else if constexpr (kIsOptional<T>) {
      value.reset();
      if (!json.is_null()) read(json, name, value.emplace());
    } else if constexpr (std::is_same_v<T, SharedVertices>) {
      value = json.is_null() ? nullptr : std::make_shared<std::vector<int>>(fields_.integers(json, name));
    } else if constexpr (kIsShared<T>) {
      value = json.is_null() ? nullptr : std::make_shared<Points>(fields_.rows(json, name));
    } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
      value = fields_.vector(json, name);
    } else if constexpr (kIsVector<T>) {
      if (!json.is_list()) fields_.fail(name, "a list");
      value.clear();
      for (std::size_t i = 0; i < json.size(); ++i) read(json.at(i), name, value.emplace_back());
    } else {
      Reader reader(json, concat("\"", name, "\" of ", fields_.what()));
      visit_fields(value, reader);
      reader.finish();
    }
  }
  template <typename Table>
  auto word(const Json& json, const char* name, const Table& table) const {
    const std::string& text = fields_.text_of(json, name);
    if (const auto found = table.find(text)) return *found;
    std::string list;
    for (const auto& entry : table.entries)
      list += (list.empty() ? "\"" : ", \"") + std::string(entry.word) + "\"";
    fields_.fail(name, "one of " + list);
  }

  Fields fields_;
  std::vector<std::string> known_;
};

}  // namespace

Json json_of(const Request& request) {
  return std::visit(
      [&](auto options) {
        Json object = Json::Object();
        object.add("kind", Json(word_of(kind_of(request))));
        Json fields = Writer::json(options);
        for (auto& [name, value] : *fields.template get<Json::Object>())
          object.add(std::move(name), std::move(value));
        return object;
      },
      request);
}

Request request_of(const Json& json) {
  const Fields fields(json, "\"request\"");
  Request request = default_request(fields.choice<RequestKind>(fields.require("kind"), "kind"));
  std::visit(
      [&](auto& options) {
        Reader reader(json, concat("the request ", word_of(kind_of(request))));
        reader.know("kind");
        visit_fields(options, reader);
        reader.finish();
      },
      request);
  return request;
}

}  // namespace batten::detail
