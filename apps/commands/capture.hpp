#pragma once
#include "commands/json.hpp"

#include <string>
#include <string_view>

#include "batten/pipeline/recorded_capture.hpp"

namespace batten::commands {

/// The text of a calibration file on one line, as recordings keep it. @param name for errors.
/// @throws FileError when it is none.
std::string calibration_line(std::string_view text, const std::string& name);

/// What came of a capture or a replay, and what is in its recording.
Json figures_of(const RecordedCapture& capture);

}  // namespace batten::commands
