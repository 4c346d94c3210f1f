#pragma once
#include "commands/json.hpp"

#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "batten/core/stage_times.hpp"

namespace batten::python {

/// JSON as dict, list, str, int, float, bool and None.
pybind11::object as_python(const commands::Json& json);

/// What --json prints of a run, its options as they were given: under the same keys.
pybind11::dict report_of(const char* command, const commands::Json& figures, const pybind11::dict& options,
                         const StageTimes& times, const std::vector<std::string>& warnings);

/// @throws Error with all flaws where they are not accepted, else adds a warning; nothing without flaws.
/// @param what begins the sentence.
void tell_flaws(const std::vector<std::string>& flaws, const std::string& what, bool accepted,
                std::vector<std::string>& warnings);

}  // namespace batten::python
