#pragma once
#include <cstdint>

#include <Eigen/Core>

namespace batten {

/// Red, green, blue in linear light, 0 … 1: the space in which light adds up.
using Colour = Eigen::Vector3f;

/// The colour of 0xRRGGBB as written in style sheets (sRGB).
Colour hex_colour(std::uint32_t rrggbb);
/// One channel to its sRGB byte; values outside [0, 1] are cut.
std::uint8_t srgb_byte(float linear);
/// The linear value of an sRGB byte.
float linear_value(std::uint8_t srgb);
/// Relative luminance (Y of CIE XYZ), 0 … 1.
float luminance(const Colour& colour);

/// For quantities with a meaningful zero in the middle (curvature): t = 0 deep blue, ½ nearly white, 1 deep
/// red. Luminance rises to the middle and falls after it. t is cut to [0, 1].
Colour diverging_colour(double t);
/// For quantities from zero up (errors): t = 0 pale, 1 dark; luminance falls all the way, so that it prints
/// in grey as well.
Colour sequential_colour(double t);

}  // namespace batten
