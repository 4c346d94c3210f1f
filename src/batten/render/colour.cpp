#include "batten/render/colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace batten {

namespace {

/// Piecewise linear in CIE Lab, where equal steps look equal.
Eigen::Vector3d lab_of(const Colour& c) {
  const Eigen::Vector3d rgb = c.cast<double>();
  const double x = (0.4124564 * rgb[0] + 0.3575761 * rgb[1] + 0.1804375 * rgb[2]) / 0.95047;
  const double y = 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2];
  const double z = (0.0193339 * rgb[0] + 0.1191920 * rgb[1] + 0.9503041 * rgb[2]) / 1.08883;
  const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
  return {116 * f(y) - 16, 500 * (f(x) - f(y)), 200 * (f(y) - f(z))};
}

Colour of_lab(const Eigen::Vector3d& lab) {
  const auto inverse = [](double t) {
    return t * t * t > 216.0 / 24389 ? t * t * t : (116 * t - 16) * 27 / 24389;
  };
  const double fy = (lab[0] + 16) / 116;
  const double x = 0.95047 * inverse(fy + lab[1] / 500), y = inverse(fy),
               z = 1.08883 * inverse(fy - lab[2] / 200);
  const Eigen::Vector3d rgb(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                            -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                            0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
  return rgb.cwiseMax(0).cwiseMin(1).cast<float>();
}

template <std::size_t n>
Colour along(const std::array<std::uint32_t, n>& stops, double t) {
  const double at = std::clamp(std::isfinite(t) ? t : 0.0, 0.0, 1.0) * (n - 1);
  const auto i = std::min(static_cast<std::size_t>(at), n - 2);
  const double w = at - static_cast<double>(i);
  return of_lab((1 - w) * lab_of(hex_colour(stops[i])) + w * lab_of(hex_colour(stops[i + 1])));
}

}  // namespace

std::uint8_t srgb_byte(float linear) {
  const float x = std::clamp(linear, 0.0F, 1.0F);
  const float s = x <= 0.0031308F ? 12.92F * x : 1.055F * std::pow(x, 1 / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

float linear_value(std::uint8_t srgb) {
  const float s = static_cast<float>(srgb) / 255;
  return s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F);
}

Colour hex_colour(std::uint32_t rrggbb) {
  return {linear_value(rrggbb >> 16 & 255), linear_value(rrggbb >> 8 & 255), linear_value(rrggbb & 255)};
}

float luminance(const Colour& colour) {
  return colour.dot(Colour(0.2126F, 0.7152F, 0.0722F));
}

Colour diverging_colour(double t) {
  return along(
      std::array<std::uint32_t, 7>{0x1f3b82, 0x4a78b8, 0xa3c4de, 0xf4f1ea, 0xe9b69a, 0xc8624f, 0x8a1c2c}, t);
}

Colour sequential_colour(double t) {
  return along(
      std::array<std::uint32_t, 7>{0xf8f5e6, 0xf6dc9b, 0xf0ae5a, 0xdd7440, 0xb63f4a, 0x7a2453, 0x371440}, t);
}

}  // namespace batten
