#pragma once
#include <string>

#include <Eigen/Core>

#include "batten/engine/reply_detail.hpp"

// Private to the room: the fields of a message. Each throws InvalidInput, with the field's name, where it is
// missing and has no default, or of another kind than is asked for.
namespace batten::detail {

const Json& field(const Json& message, const char* name);
std::string text_of(const Json& message, const char* name);
double number_of(const Json& message, const char* name, double otherwise);
Eigen::Vector3d point_of(const Json& message, const char* name);
Eigen::Vector3d point_of(const Json& message, const char* name, const Eigen::Vector3d& otherwise);
/// Whether a field is there and true.
bool flag_of(const Json& message, const char* name);

}  // namespace batten::detail
