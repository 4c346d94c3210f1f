#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "batten/render/colour.hpp"

namespace batten {

/// A picture: rows from top to bottom, three bytes (sRGB red, green, blue) per pixel.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  Image() = default;
  /// Filled with one colour. @throws InvalidInput unless both sides are 1 … 16384.
  Image(int width, int height, const Colour& fill);

  /// The three bytes of a pixel. @pre it lies within the picture.
  std::uint8_t* at(int x, int y) { return &pixels[3 * (static_cast<std::size_t>(y) * width + x)]; }
  const std::uint8_t* at(int x, int y) const {
    return &pixels[3 * (static_cast<std::size_t>(y) * width + x)];
  }
  /// Mixes `colour` over a pixel by `cover` in [0, 1], in linear light. Outside the picture nothing happens.
  void blend(int x, int y, const Colour& colour, float cover);
  /// Copies `other` with its upper left corner at (x, y), cut at the borders.
  void paste(const Image& other, int x, int y);
};

/// The bytes of a PNG file, the same for the same picture.
/// @throws Error when the picture cannot be compressed (no memory).
std::string encode_png(const Image& image);

}  // namespace batten
