#pragma once
#include <string>

#include "batten/core/progress.hpp"
#include "batten/session/results.hpp"

namespace batten::studio {

/// A surface of curves, or of a model, as the text of a STEP file, as `batten surface` and `batten sketch`
/// write it.
/// @param unit of its lengths, such as "mm"; empty stands for metres. @throws InvalidInput where it is no
/// unit, where the result is no such surface, or without Open Cascade, with how to get it; as step_surface();
/// Cancelled.
std::string step_file(const RequestResult& made, const std::string& unit, const Progress& progress = {});

}  // namespace batten::studio
