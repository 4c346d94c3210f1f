#pragma once
#include <string>

#include <CLI/CLI.hpp>

namespace batten::cli {

// Commands whose work is done by commands of their own: `batten rig check`.

/// Adds such a command; its own are added to what is returned, by add_command().
CLI::App* add_group(CLI::App& app, const std::string& name, const std::string& description);

/// The words of a command as they are typed: "surface", "rig check".
std::string command_words(const CLI::App& command);

// One function per group, each in its own source; registered in command.cpp.
void add_rig(CLI::App& app);

}  // namespace batten::cli
