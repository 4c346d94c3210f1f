#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/error.hpp"

namespace batten {

/// A member of an enumeration and the word for it in options, files and other languages.
template <typename Enum>
struct Choice {
  Enum value;
  std::string_view word;
};

/// The words of an enumeration; in the order in which they are listed to users. A value that comes again is
/// an alias: read, never written. Stands beside its enumeration, in a function that word_of() and
/// parse_choice() find:
///
///     enum class Shape { Sphere, Torus };
///     constexpr auto choices_of(Shape) {
///       return choices<Shape>("shape", {{Shape::Sphere, "sphere"}, {Shape::Torus, "torus"}, {Shape::Torus,
///       "ring"}});
///     }
///     word_of(Shape::Torus) == "torus";  parse_choice<Shape>("ring") == Shape::Torus;
template <typename Enum, std::size_t N>
struct Choices {
  std::string_view kind;  ///< what is chosen, singular: "fairing method"
  std::array<Choice<Enum>, N> entries;

  /// The value that a word stands for; nothing where it is none of them.
  constexpr std::optional<Enum> find(std::string_view word) const {
    for (const Choice<Enum>& entry : entries)
      if (entry.word == word) return entry.value;
    return std::nullopt;
  }
  /// Empty where the value has no word.
  constexpr std::string_view word(Enum value) const {
    for (const Choice<Enum>& entry : entries)
      if (entry.value == value) return entry.word;
    return {};
  }
  constexpr bool is_alias(std::size_t i) const { return word(entries[i].value) != entries[i].word; }
};

/// A table of choices. A word that stands for two values, or an empty one, does not compile.
template <typename Enum, std::size_t N>
consteval Choices<Enum, N> choices(std::string_view kind, const Choice<Enum> (&entries)[N]) {
  Choices<Enum, N> table{kind, {}};
  for (std::size_t i = 0; i < N; ++i) {
    if (entries[i].word.empty()) throw std::logic_error("a choice without a word");
    for (std::size_t j = 0; j < i; ++j)
      if (entries[i].word == entries[j].word) throw std::logic_error("two choices with one word");
    table.entries[i] = entries[i];
  }
  return table;
}

/// The word for a value, the first in the table where there are aliases.
template <typename Enum>
constexpr std::string_view word_of(Enum value) {
  return choices_of(value).word(value);
}

/// All words but aliases, in the order of the table.
template <typename Enum>
std::vector<std::string> choice_words() {
  constexpr auto table = choices_of(Enum{});
  std::vector<std::string> words;
  for (std::size_t i = 0; i < table.entries.size(); ++i)
    if (!table.is_alias(i)) words.emplace_back(table.entries[i].word);
  return words;
}

/// All values that have a word, in the order of the table.
template <typename Enum>
std::vector<Enum> choice_values() {
  constexpr auto table = choices_of(Enum{});
  std::vector<Enum> values;
  for (std::size_t i = 0; i < table.entries.size(); ++i)
    if (!table.is_alias(i)) values.push_back(table.entries[i].value);
  return values;
}

/// The value that a word or alias stands for.
/// @throws InvalidInput "'x' is no KIND; choose one of A, B, C".
template <typename Enum>
Enum parse_choice(std::string_view word) {
  constexpr auto table = choices_of(Enum{});
  if (const std::optional<Enum> value = table.find(word)) return *value;
  std::string list;
  for (const std::string& other : choice_words<Enum>()) list += (list.empty() ? "" : ", ") + other;
  throw InvalidInput("'" + std::string(word) + "' is no " + std::string(table.kind) + "; choose one of " +
                     list);
}

}  // namespace batten
