#pragma once
#include <string>
#include <string_view>

#include "batten/session/document.hpp"

namespace batten {

/// One edit as a line of a session (docs/sketch.md), without the end of the line. Numbers read back bit for
/// bit.
std::string format_edit(const Edit& edit);

/// @throws InvalidInput when the line is no JSON object, or naming the op or field that is unknown, missing
/// or of the wrong kind, with what was expected.
Edit parse_edit(std::string_view line);

/// The name of the op: "insert", "delete", …
std::string name_of_op(const Edit& edit);

/// Whether a text is one whole JSON value; a line that a writer did not finish is none.
bool is_whole_json(std::string_view text);

/// The first line of a session: its unit. @throws InvalidInput.
std::string parse_session_header(std::string_view line);
std::string format_session_header(const std::string& unit);

}  // namespace batten
