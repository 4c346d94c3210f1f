#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "batten/core/arrays.hpp"
#include "batten/engine/reply.hpp"

// Private to the room: how replies are put together.
namespace batten::detail {

using Json = nlohmann::json;

/// A reply while it is made: its JSON as a value.
struct Draft {
  Json json = Json::object();
  std::vector<ReplyArray> arrays;

  /// n × 3 in single precision, less an origin: single precision is enough around the middle of a model, not
  /// far from zero.
  void add_points(std::string name, const Points& points, const Eigen::RowVector3d& origin);
  void add_values(std::string name, const Eigen::VectorXd& values);
  void add_indices(std::string name, const std::vector<int>& indices);
  void add_triangles(std::string name, const Triangles& triangles);
  void add_bytes(std::string name, const std::string& bytes);
};

Json json_of(const Eigen::RowVector3d& point);
/// Null where the number is not finite: JSON has no word for it.
Json json_of(double value);

}  // namespace batten::detail
