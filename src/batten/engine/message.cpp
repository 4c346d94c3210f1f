#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/engine/message_detail.hpp"

namespace batten::detail {

const Json& field(const Json& message, const char* name) {
  const auto found = message.find(name);
  if (found == message.end()) throw InvalidInput(concat("the message has no '", name, "'"));
  return *found;
}

std::string text_of(const Json& message, const char* name) {
  const Json& value = field(message, name);
  if (!value.is_string()) throw InvalidInput(concat("'", name, "' of the message must be text"));
  return value.get<std::string>();
}

double number_of(const Json& message, const char* name, double otherwise) {
  const auto found = message.find(name);
  if (found == message.end()) return otherwise;
  if (!found->is_number()) throw InvalidInput(concat("'", name, "' of the message must be a number"));
  return found->get<double>();
}

Eigen::Vector3d point_of(const Json& message, const char* name) {
  const Json& value = field(message, name);
  Eigen::Vector3d point;
  for (int k = 0; k < 3; ++k) {
    if (!value.is_array() || value.size() != 3 || !value[at(k)].is_number())
      throw InvalidInput(concat("'", name, "' of the message must be three numbers"));
    point[k] = value[at(k)].get<double>();
  }
  return point;
}
Eigen::Vector3d point_of(const Json& message, const char* name, const Eigen::Vector3d& otherwise) {
  return message.contains(name) ? point_of(message, name) : otherwise;
}

bool flag_of(const Json& message, const char* name) {
  const auto found = message.find(name);
  return found != message.end() && found->is_boolean() && found->get<bool>();
}

}  // namespace batten::detail
