#include <cstdio>

#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/render/colour_scale_detail.hpp"
#include "batten/render/lettering.hpp"
#include "batten/render/palette_detail.hpp"

namespace batten::detail {

namespace {

std::vector<double> finite_values(const Eigen::VectorXd& values) {
  std::vector<double> list;
  for (const double value : values)
    if (std::isfinite(value)) list.push_back(value);
  return list;
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

ColourScale error_scale(const Eigen::VectorXd& values, const std::string& unit, double range) {
  ColourScale scale;
  std::vector<double> list = finite_values(values);
  double largest = 0;
  for (const double value : list) largest = std::max(largest, value);
  scale.high = range > 0 ? range : percentile(list, 0.99);
  if (!(scale.high > 0)) scale.high = largest > 0 ? largest : 1;
  scale.title = unit;
  scale.note = concat("max ", short_number(largest));
  return scale;
}

ColourScale curvature_scale(const Eigen::VectorXd& values, const std::string& title, double range) {
  ColourScale scale;
  std::vector<double> sizes;
  for (const double value : finite_values(values)) sizes.push_back(std::abs(value));
  scale.high = range > 0 ? range : percentile(sizes, 0.97);
  if (!(scale.high > 0)) scale.high = 1;
  scale.low = -scale.high;
  scale.diverging = true;
  scale.title = title;
  return scale;
}

std::vector<double> ticks(double low, double high) {
  const double rough = (high - low) / 5;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0})
    if (rough <= factor * power) {
      step = factor * power;
      break;
    }
  std::vector<double> list;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
    list.push_back(k * step + 0.0);  // never minus zero
  return list;
}

double bar_width(int width, int height) {
  return 0.13 * std::min(width, height) + 40;
}

void draw_bar(Image& image, const ColourScale& scale) {
  const double cap = std::max(8.0, 0.0165 * std::min(image.width, image.height));
  const double room = bar_width(image.width, image.height);
  const double x0 = image.width - room + 0.1 * room, x1 = x0 + 0.17 * room;
  const double y0 = 0.16 * image.height, y1 = 0.86 * image.height;
  for (int y = static_cast<int>(y0); y < static_cast<int>(y1); ++y) {
    const double value = scale.high - (scale.high - scale.low) * (y + 0.5 - y0) / (y1 - y0);
    const Colour colour = scale.colour(value);
    for (int x = static_cast<int>(x0); x < static_cast<int>(x1); ++x) image.blend(x, y, colour, 1);
  }
  for (const double value : ticks(scale.low, scale.high)) {
    const double y = y1 - (y1 - y0) * (value - scale.low) / (scale.high - scale.low);
    draw_line(image, x1 - 0.3 * (x1 - x0), y, x1 - 1, y, 1,
              kInk);  // inside: beside the number it would be a minus
    draw_text(image, x1 + 0.6 * cap, y + 0.5 * cap, short_number(value), cap, kInk);
  }
  draw_text(image, image.width - 0.1 * room, y0 - 1.8 * cap, scale.title, cap, kInk, Align::Right);
  draw_text(image, x0, y1 + 2.2 * cap, scale.note, cap, kInk);
}

}  // namespace batten::detail
