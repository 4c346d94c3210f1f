#pragma once
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

// What shells and `man` know of the program, generated from the options themselves, so that they cannot
// differ.
namespace batten::cli {

/// The two commands that only print what shells and `man` want to know.
class ShellHelp {
 public:
  explicit ShellHelp(CLI::App& app);
  /// The text of the one that was asked for; nothing where it was another command.
  /// @throws CLI::ValidationError where there is no such command.
  std::optional<std::string> text(const CLI::App& app) const;

 private:
  std::string shell_, page_;
  CLI::App *completion_ = nullptr, *manual_ = nullptr;
};

}  // namespace batten::cli
