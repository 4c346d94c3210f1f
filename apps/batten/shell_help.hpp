#pragma once
#include <string>

#include <CLI/CLI.hpp>

// What shells and `man` know of the program, generated from the options themselves, so that they cannot
// differ.
namespace batten::cli {

/// The completion of commands, options and the words that an option takes, to be sourced by the shell.
/// @param shell "bash", "zsh" or "fish".
std::string completion(const CLI::App& app, const std::string& shell);

/// A manual page in troff: of the program, or of one of its commands.
/// @param command null: the program.
std::string manual_page(const CLI::App& app, const CLI::App* command);

}  // namespace batten::cli
