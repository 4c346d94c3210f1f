#pragma once
#include <string_view>

#include "batten/core/choices.hpp"

namespace batten {

/// A length as a user writes it: `0.05` (in the unit of the file), `2mm` (metric; files are in metres unless
/// they say otherwise) or `1.6%` (of the diameter).
struct Length {
  enum class Kind {
    Plain,     ///< in the unit of the file
    Metres,    ///< written with a unit: mm, cm, m, um, km, in, ft
    Relative,  ///< a fraction of the diameter
  };
  double value = 0;
  Kind kind = Kind::Plain;

  /// The length in the unit of the file.
  /// @param diameter in the unit of the file.
  /// @param metres_per_unit the unit of the file; 1 for metres.
  double in_file_units(double diameter, double metres_per_unit = 1.0) const;
};

constexpr auto choices_of(Length::Kind) {
  return choices<Length::Kind>("kind of length", {{Length::Kind::Plain, "plain"},
                                                  {Length::Kind::Metres, "metres"},
                                                  {Length::Kind::Relative, "relative"}});
}

/// @throws InvalidInput naming the text and the accepted forms.
Length parse_length(std::string_view text);
/// `2deg`, `0.03rad`, or a plain number in degrees. @return radians.
double parse_angle(std::string_view text);
/// `0.3%` or `0.003`. @return the fraction.
double parse_fraction(std::string_view text);

constexpr double kPi = 3.14159265358979323846;
/// What makers of sensors call 1 g, m/s²: the conventional value of 1901.
constexpr double kStandardGravity = 9.80665;
/// Gravity where the place is not known, m/s²: 9.76 to 9.83 over the surface of the earth, so a fourth digit
/// would say nothing.
constexpr double kUsualGravity = 9.81;
/// An angle in radians, and in degrees.
constexpr double radians(double degrees) {
  return degrees * kPi / 180.0;
}
/// An angle in degrees from one in radians.
constexpr double degrees(double radians) {
  return radians * 180.0 / kPi;
}

}  // namespace batten
