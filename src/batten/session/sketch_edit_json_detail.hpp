#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/session/json_detail.hpp"
#include "batten/session/sketch_edit.hpp"

// Private to the room: tools of models in journals (docs/sketch.md).
namespace batten::detail {

/// Appends the fields of an edit to its line.
void put_fields(Json& line, const SketchEdit& edit);

/// Reads the fields of a tool; nothing where there is no tool of that name.
/// @param common the fields of the line that are not of the tool. @throws InvalidInput naming the field.
std::optional<SketchEdit> sketch_edit_of(const Json& line, const std::string& op,
                                         const std::vector<std::string>& common);

}  // namespace batten::detail
