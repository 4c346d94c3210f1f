#pragma once
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/mesh/handles.hpp"

namespace batten {

/// Reads handles: {"fixed": SELECT, "handles": [{"select": SELECT, "translate": [x,y,z], "rotate_deg":
/// [ax,ay,az,angle], "about": [x,y,z]} or {"select": SELECT, "targets": [[x,y,z], …]}]}, with SELECT one of
/// {"vertices": […]}, {"box": [[x,y,z],[x,y,z]]} and {"sphere": [x,y,z,r]} (borders of both belong to them).
/// "fixed" may be left out, and "about" (then the origin).
/// @throws FileError naming the member: unknown or wrong, a selection without vertices, a vertex selected
/// twice.
Handles read_handles(const std::string& path, const Points& positions);
/// The same from memory; `name` stands for the path in errors.
Handles parse_handles(const std::string& text, const std::string& name, const Points& positions);

}  // namespace batten
