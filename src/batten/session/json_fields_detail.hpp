#pragma once
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"
#include "batten/session/json_detail.hpp"

// Private to the room: typed reading of JSON objects, with errors that name the field and what was expected.
namespace batten::detail {

/// A value in a sentence: as it stands where it is short.
std::string shown(const Json& value);

/// The fields of one object. @throws InvalidInput from every function, naming object and field.
class Fields {
 public:
  /// Borrows `object`. @param what names it in errors: "op insert".
  Fields(const Json& object, std::string what);
  /// Refuses fields other than these, listing them.
  Fields(const Json& object, std::string what, const std::vector<std::string>& known);

  const std::string& what() const { return what_; }
  const Json* find(std::string_view name) const { return object_.find(name); }
  const Json& require(std::string_view name) const;
  [[noreturn]] void fail(std::string_view name, std::string_view expected) const;
  void refuse_others(const std::vector<std::string>& known) const;

  double number(std::string_view name, double otherwise) const;
  double number_of(const Json& value, std::string_view name) const;
  int integer_of(const Json& value, std::string_view name) const;
  bool flag(std::string_view name) const;
  bool flag_of(const Json& value, std::string_view name) const;
  const std::string& text_of(const Json& value, std::string_view name) const;
  /// A text of a kind letter and a number, such as "c3".
  int id_of(const Json& value, std::string_view name, char kind, std::string_view expected) const;
  int curve(const Json& value, std::string_view name) const;
  int vertex(const Json& value, std::string_view name) const;
  /// A list of [x, y, z].
  Points points(const Json& value, std::string_view name) const;
  /// A flat list of numbers, of which "nan", "inf" and "-inf" are some.
  std::vector<double> numbers(const Json& value, std::string_view name) const;
  std::vector<int> integers(const Json& value, std::string_view name) const;
  /// A flat list, row by row. Its length must be a multiple of `columns`.
  Points rows(const Json& value, std::string_view name) const;
  Eigen::Vector3d vector(const Json& value, std::string_view name) const;

  template <typename Enum>
  Enum choice(const Json& value, std::string_view name) const {
    const std::string& word = text_of(value, name);
    try {
      return parse_choice<Enum>(word);
    } catch (const InvalidInput& error) {
      throw InvalidInput("the field \"" + std::string(name) + "\" of " + what_ + ": " + error.what());
    }
  }

 private:
  const Json& object_;
  std::string what_;
};

Json list_of_points(const Points& points);
Json flat_list(const Points& rows);
Json flat_list(const Eigen::VectorXd& values);
Json flat_list(const std::vector<int>& values);
Json flat_list(const Eigen::Vector3d& vector);
std::string id_text(char kind, int number);

}  // namespace batten::detail
