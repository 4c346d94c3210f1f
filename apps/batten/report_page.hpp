#pragma once
#include "command.hpp"

#include <string>

namespace batten::cli {

/// Writes the HTML report of a run: what it made, drawn in every fitting shading, its figures, stage times,
/// options and warnings. @throws FileError.
void write_report(const std::string& path, const CLI::App& command, const Outcome& outcome,
                  const Progress& progress);

}  // namespace batten::cli
