#pragma once
#include <functional>
#include <string>

#include "batten/session/journal.hpp"
#include "batten/session/json_detail.hpp"

// Private to the room: journals as text, also those within project files, whose lists may stand elsewhere.
namespace batten::detail {

/// @param resolve puts lists that stand elsewhere into their places; it may throw InvalidInput.
Session parse_session(const std::string& text, const std::string& path,
                      const std::function<void(Json&)>& resolve);

}  // namespace batten::detail
