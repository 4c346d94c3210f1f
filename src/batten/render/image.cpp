#include "batten/render/image.hpp"

#include <algorithm>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

Image::Image(int w, int h, const Colour& fill) : width(w), height(h) {
  constexpr int kMost = 16384;
  if (w < 1 || h < 1 || w > kMost || h > kMost)
    throw InvalidInput(concat("a picture must be 1 to ", kMost, " pixels wide and high, got ", w, "x", h));
  const std::uint8_t bytes[3] = {srgb_byte(fill[0]), srgb_byte(fill[1]), srgb_byte(fill[2])};
  pixels.resize(3 * static_cast<std::size_t>(w) * h);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = bytes[i % 3];
}

void Image::blend(int x, int y, const Colour& colour, float cover) {
  if (x < 0 || y < 0 || x >= width || y >= height || !(cover > 0)) return;
  const float a = std::min(cover, 1.0F);
  std::uint8_t* pixel = at(x, y);
  for (int k = 0; k < 3; ++k) pixel[k] = srgb_byte((1 - a) * linear_value(pixel[k]) + a * colour[k]);
}

void Image::paste(const Image& other, int x, int y) {
  for (int row = std::max(0, -y); row < std::min(other.height, height - y); ++row) {
    const int from = std::max(0, -x), to = std::min(other.width, width - x);
    if (from < to)
      std::copy(other.at(from, row), other.at(from, row) + 3 * (to - from), at(x + from, y + row));
  }
}

}  // namespace batten
