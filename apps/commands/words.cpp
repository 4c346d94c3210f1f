#include "commands/words.hpp"

#include "batten/core/text.hpp"

namespace batten::commands {

bool is_first_word(const std::string& word, const char* option, const char* first, const char* second) {
  if (word != first && word != second)
    throw InvalidInput(concat(option, " must be ", first, " or ", second, ", got '", word, "'"));
  return word == first;
}

}  // namespace batten::commands
