#pragma once
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace batten {

/// Joins values of any printable type into one string; numbers with six significant digits.
template <typename... Values>
std::string concat(const Values&... values) {
  std::ostringstream out;
  (out << ... << values);
  return out.str();
}

/// The shortest decimal text that reads back as exactly `value` (17 significant digits at most).
std::string exact_decimal(double value);

/// Reads a whole token as a number, independent of the locale. Accepts inf and nan, so that the caller can
/// name them; false when anything but the number stands in the token.
bool parse_number(std::string_view token, double& value);
bool parse_integer(std::string_view token, long& value);

/// The tokens of a line, separated by blanks (space, tab, carriage return).
std::vector<std::string_view> split_blanks(std::string_view line);
/// The fields of a line, separated by `separator`, blanks around each field removed; empty fields are kept.
std::vector<std::string_view> split_fields(std::string_view line, char separator);
/// The text without blanks at either end.
std::string_view trim(std::string_view text);
/// The text with the letters A to Z as a to z, whatever the locale.
std::string lower_case(std::string_view text);

}  // namespace batten
