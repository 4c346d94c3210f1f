#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace batten {

/// What a camera saw: rows from top to bottom, one byte of brightness per pixel.
struct GreyImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  /// Brightness of a pixel, 0 … 255. @pre it lies within the image.
  std::uint8_t at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

}  // namespace batten
