#pragma once
#include "batten/session/edit.hpp"
#include "batten/session/json_detail.hpp"

// Private to the room: edits of format 2 as values.
namespace batten::detail {

Json json_of(const Edit& edit);
/// @throws InvalidInput naming the op or field.
Edit edit_of(const Json& line);
/// A line of format 1: a tool of the one model there is, o1, undo or redo.
Edit edit_of_format_1(const Json& line);

Json json_of(ObjectId id);

/// The fields that say what an object is: "kind", "name", and content, unit and all, or source and request.
void put_object(Json& line, const Object& object);

}  // namespace batten::detail
