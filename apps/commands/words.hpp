#pragma once
#include <string>

#include "batten/core/error.hpp"

namespace batten::commands {

/// Options that do not go together, or one that is missing: bad usage, whatever the input.
class UsageError : public InvalidInput {
  using InvalidInput::InvalidInput;
};

/// Whether an option of two words has the first. @param option as the command line has it, `--keep-border`.
/// @throws InvalidInput where it has neither.
bool is_first_word(const std::string& word, const char* option, const char* first, const char* second);

}  // namespace batten::commands
