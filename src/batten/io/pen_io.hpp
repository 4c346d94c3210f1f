#pragma once
#include <string>

#include "batten/camera/pen.hpp"

namespace batten {

/// A pen and how well it is known.
struct CalibratedPen {
  Pen pen;
  double tip_offset_sigma = 0;               ///< standard deviation, metres; 0: not known
  std::array<double, kPenLeds> led_sigma{};  ///< the same of the LEDs
  double residual = 0;                       ///< of the calibration, metres (calibrate_pivot())
};

/// Reads a pen (docs/files.md#pens). Figures of the calibration may be missing.
/// @throws FileError with file, place and remedy: no JSON, no pen, a newer version, numbers out of range.
CalibratedPen read_pen(const std::string& path);
/// The same from memory; `name` stands for the path in errors.
CalibratedPen parse_pen(const std::string& text, const std::string& name);

/// What parse_pen() reads back bit for bit. @throws InvalidInput as problem() of the pen.
std::string format_pen(const CalibratedPen& pen);
/// @throws FileError, InvalidInput.
void write_pen(const CalibratedPen& pen, const std::string& path);

}  // namespace batten
