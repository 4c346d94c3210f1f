#pragma once
#include <string>
#include <string_view>

#include "batten/session/edit.hpp"

namespace batten {

/// One edit as a line of a journal (docs/projects.md), without the end of the line. Numbers read back bit for
/// bit. @throws InvalidInput when a text is not UTF-8; a Document refuses such edits.
std::string format_edit(const Edit& edit);

/// @throws InvalidInput when the line is no JSON object, or naming the op or field that is unknown, missing
/// or of the wrong kind, with what was expected.
Edit parse_edit(std::string_view line);

/// A line of format 1, whose edits are those of one model, o1 here. @throws InvalidInput as parse_edit().
Edit parse_edit_of_format_1(std::string_view line);

/// Whether a text is one whole JSON value; a line that a writer did not finish is none.
bool is_whole_json(std::string_view text);

/// What the first line of a journal says.
struct SessionHeader {
  int format = 2;    ///< 1 or 2
  std::string unit;  ///< of the one model of format 1
};
/// @throws InvalidInput.
SessionHeader parse_session_header(std::string_view line);
/// The header of format 2.
std::string format_session_header();

}  // namespace batten
