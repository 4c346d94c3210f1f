#include "batten/core/text.hpp"

#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace batten {

namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// Decimal numbers of at most 15 digits and a small power of ten, that is nearly all in files: both the
/// digits and the power are exact in double, so one correctly rounded operation gives what strtod gives, ten
/// times faster. False when the token is anything else.
bool parse_short_decimal(std::string_view token, double& value) {
  static constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                       1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  size_t i = 0;
  const bool negative = !token.empty() && token[0] == '-';
  if (negative || (!token.empty() && token[0] == '+')) ++i;
  long long digits = 0;
  int n_digits = 0, exponent = 0;
  bool seen_point = false, seen_digit = false;
  for (; i < token.size(); ++i) {
    const char c = token[i];
    if (c == '.' && !seen_point) {
      seen_point = true;
    } else if (c >= '0' && c <= '9') {
      seen_digit = true;
      if (digits != 0 || c != '0') ++n_digits;
      if (n_digits > 15) return false;
      digits = 10 * digits + (c - '0');
      if (seen_point) --exponent;
    } else {
      break;
    }
  }
  if (!seen_digit) return false;
  if (i < token.size()) {
    if (token[i] != 'e' && token[i] != 'E') return false;
    ++i;
    const bool down = i < token.size() && token[i] == '-';
    if (i < token.size() && (token[i] == '-' || token[i] == '+')) ++i;
    if (i == token.size() || token.size() - i > 3) return false;
    int written = 0;
    for (; i < token.size(); ++i) {
      if (token[i] < '0' || token[i] > '9') return false;
      written = 10 * written + (token[i] - '0');
    }
    exponent += down ? -written : written;
  }
  if (exponent < -22 || exponent > 22) return false;
  const double magnitude = exponent < 0 ? static_cast<double>(digits) / kPowers[-exponent]
                                        : static_cast<double>(digits) * kPowers[exponent];
  value = negative ? -magnitude : magnitude;
  return true;
}

}  // namespace

std::string exact_decimal(double value) {
  char buffer[32];
  // A decimal of up to 15 digits survives the way through a double, so 15 digits (%g drops the zeros at the
  // end) already give the shortest text where one that short exists; only denormal numbers hold fewer.
  const bool denormal =
      value != 0 && value > -std::numeric_limits<double>::min() && value < std::numeric_limits<double>::min();
  for (int digits = denormal ? 1 : 15; digits <= 17; ++digits) {
    std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
    if (std::strtod(buffer, nullptr) == value) break;
  }
  return buffer;
}

bool parse_number(std::string_view token, double& value) {
  if (parse_short_decimal(token, value)) return true;
  // strtod needs a terminated copy; numbers are short. std::from_chars for double is missing in the
  // browser's standard library. The program never changes the locale, so the decimal point is a point.
  constexpr size_t kLongest = 120;
  if (token.empty() || token.size() > kLongest || is_blank(token.front())) return false;
  char buffer[kLongest + 1];
  token.copy(buffer, token.size());
  buffer[token.size()] = '\0';
  char* end = nullptr;
  const double parsed = std::strtod(buffer, &end);
  if (end != buffer + token.size()) return false;
  value = parsed;
  return true;
}

bool parse_integer(std::string_view token, long& value) {
  if (token.empty() || token.size() > 20 || is_blank(token.front())) return false;
  const std::string copy(token);
  char* end = nullptr;
  errno = 0;
  const long parsed = std::strtol(copy.c_str(), &end, 10);
  if (end != copy.c_str() + copy.size() || errno == ERANGE) return false;
  value = parsed;
  return true;
}

std::vector<std::string_view> split_blanks(std::string_view line) {
  std::vector<std::string_view> tokens;
  size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && is_blank(line[i])) ++i;
    const size_t begin = i;
    while (i < line.size() && !is_blank(line[i])) ++i;
    if (i > begin) tokens.push_back(line.substr(begin, i - begin));
  }
  return tokens;
}

std::vector<std::string_view> split_fields(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  size_t begin = 0;
  while (true) {
    const size_t end = line.find(separator, begin);
    fields.push_back(trim(line.substr(begin, end == std::string_view::npos ? end : end - begin)));
    if (end == std::string_view::npos) return fields;
    begin = end + 1;
  }
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

}  // namespace batten
