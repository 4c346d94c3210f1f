#pragma once
#include <string_view>

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

/// @throws InvalidInput naming the text and the accepted forms.
Length parse_length(std::string_view text);
/// `2deg`, `0.03rad`, or a plain number in degrees. @return radians.
double parse_angle(std::string_view text);
/// `0.3%` or `0.003`. @return the fraction.
double parse_fraction(std::string_view text);

constexpr double kPi = 3.14159265358979323846;
constexpr double radians(double degrees) {
  return degrees * kPi / 180.0;
}
constexpr double degrees(double radians) {
  return radians * 180.0 / kPi;
}

}  // namespace batten
