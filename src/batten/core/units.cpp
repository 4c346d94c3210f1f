#include "batten/core/units.hpp"

#include <cmath>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

struct Suffixed {
  double number = 0;
  std::string_view suffix;
};

Suffixed split_suffix(std::string_view text, std::string_view what) {
  const std::string_view trimmed = trim(text);
  const size_t end = trimmed.find_last_of("0123456789.");
  Suffixed result;
  if (end == std::string_view::npos || !parse_number(trimmed.substr(0, end + 1), result.number) ||
      !std::isfinite(result.number)) {
    throw InvalidInput(concat("'", text, "' is not ", what));
  }
  result.suffix = trim(trimmed.substr(end + 1));
  return result;
}

}  // namespace

double Length::in_file_units(double diameter, double metres_per_unit) const {
  switch (kind) {
    case Kind::Plain:
      return value;
    case Kind::Metres:
      return value / metres_per_unit;
    case Kind::Relative:
      return value * diameter;
  }
  return value;
}

Length parse_length(std::string_view text) {
  constexpr std::string_view kWhat =
      "a length: write 0.05 (unit of the file), 2mm, or 1.6% (of the diameter)";
  const auto [number, suffix] = split_suffix(text, kWhat);
  if (suffix.empty()) return {number, Length::Kind::Plain};
  if (suffix == "%") return {number / 100, Length::Kind::Relative};
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr Unit kUnits[] = {{"um", 1e-6}, {"mm", 1e-3},   {"cm", 1e-2},  {"m", 1},
                             {"km", 1e3},  {"in", 0.0254}, {"ft", 0.3048}};
  for (const Unit& unit : kUnits) {
    if (suffix == unit.name) return {number * unit.metres, Length::Kind::Metres};
  }
  throw InvalidInput(concat("'", text, "' is not ", kWhat));
}

double parse_angle(std::string_view text) {
  constexpr std::string_view kWhat = "an angle: write 2deg or 0.035rad";
  const auto [number, suffix] = split_suffix(text, kWhat);
  if (suffix.empty() || suffix == "deg") return radians(number);
  if (suffix == "rad") return number;
  throw InvalidInput(concat("'", text, "' is not ", kWhat));
}

double parse_fraction(std::string_view text) {
  constexpr std::string_view kWhat = "a fraction: write 0.3% or 0.003";
  const auto [number, suffix] = split_suffix(text, kWhat);
  if (suffix.empty()) return number;
  if (suffix == "%") return number / 100;
  throw InvalidInput(concat("'", text, "' is not ", kWhat));
}

}  // namespace batten
