#pragma once
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

// Shared by the readers of JSON documents; not part of the library's interface.
namespace batten::detail {

/// Takes entries out of a document; every error names file and place.
class JsonReader {
 public:
  using Json = nlohmann::ordered_json;

  /// @param remedy ends the sentence about a document that is broken: "write the file with batten calibrate".
  JsonReader(std::string path, std::string remedy) : path_(std::move(path)), remedy_(std::move(remedy)) {}

  Json parse(const std::string& text) const {
    try {
      return Json::parse(text);
    } catch (const nlohmann::json::parse_error& error) {
      fail(concat("is not valid JSON near byte ", error.byte, "; ", remedy_));
    } catch (const nlohmann::json::exception&) {  // numbers beyond the range of double
      fail(concat("holds a number that is out of range; ", remedy_));
    }
  }

  const Json& member(const Json& object, const std::string& key, const std::string& where) const {
    if (!object.is_object() || !object.contains(key)) fail(concat(where, key, " is missing; ", remedy_));
    return object.at(key);
  }

  /// The member `where` + `key`, a finite number.
  double number(const Json& object, const std::string& key, const std::string& where) const {
    const Json& value = member(object, key, where);
    if (!value.is_number()) fail(concat(where, key, " must be a number"));
    if (!std::isfinite(value.get<double>())) fail(concat(where, key, " must be finite"));
    return value.get<double>();
  }

  /// The same, a whole number from 0 to 1,000,000.
  int count(const Json& object, const std::string& key, const std::string& where) const {
    const double value = number(object, key, where);
    if (!(value >= 0 && value <= 1e6) || value != std::floor(value))
      fail(concat(where, key, " must be a whole number from 0 to 1000000"));
    return static_cast<int>(value);
  }

  Eigen::Vector3d vector(const Json& value, const std::string& where) const {
    if (!value.is_array() || value.size() != 3) fail(concat(where, " must be a list of 3 numbers"));
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) {
      const Json& entry = value[static_cast<size_t>(k)];
      if (!entry.is_number()) fail(concat(where, " must be a list of 3 numbers"));
      v[k] = entry.get<double>();
    }
    if (!v.allFinite()) fail(concat(where, " must be finite"));
    return v;
  }

  /// Three rows of three numbers.
  Eigen::Matrix3d matrix(const Json& rows, const std::string& where) const {
    if (!rows.is_array() || rows.size() != 3) fail(where + " must be a list of 3 rows of 3 numbers");
    Eigen::Matrix3d matrix;
    for (int i = 0; i < 3; ++i)
      matrix.row(i) = vector(rows[static_cast<size_t>(i)], concat(where, "[", i, "]"));
    return matrix;
  }

  static Json list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
  static Json list(const Eigen::Matrix3d& matrix) {
    Json rows = Json::array();
    for (int i = 0; i < 3; ++i) rows.push_back(list(Eigen::Vector3d(matrix.row(i).transpose())));
    return rows;
  }

  [[noreturn]] void fail(const std::string& problem) const { throw FileError(path_, 0, problem); }

 private:
  std::string path_, remedy_;
};

}  // namespace batten::detail
