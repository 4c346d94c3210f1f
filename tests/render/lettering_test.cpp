#include "batten/render/lettering.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

// Letters stay within their width and between the descender and the cap height; every glyph leaves its own
// mark.
TEST(DrawText, StaysInItsLine) {
  const std::string letters = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.,:-+=%/()";
  std::vector<std::vector<std::uint8_t>> seen;
  for (const char letter : letters) {
    Image image(60, 60, Colour::Ones());
    draw_text(image, 20, 40, std::string(1, letter), 24, Colour::Zero());
    const double width = text_width(std::string(1, letter), 24);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 60; ++x)
        if (image.at(x, y)[0] < 255) {
          EXPECT_GE(x, 20 - 3) << letter;
          EXPECT_LE(x, 20 + width + 3) << letter;
          EXPECT_GE(y, 40 - 24 - 5) << letter;
          EXPECT_LE(y, 40 + 8 + 3) << letter;
        }
    for (const auto& other : seen) EXPECT_NE(other, image.pixels) << letter;
    seen.push_back(image.pixels);
  }
}

TEST(DrawText, AlignsByItsWidth) {
  EXPECT_EQ(text_width("", 10), 0);
  EXPECT_GT(text_width("mm", 10), text_width("m", 10) * 2);
  Image left(100, 20, Colour::Ones()), right = left;
  draw_text(left, 90 - text_width("error 3", 10), 15, "error 3", 10, Colour::Zero());
  draw_text(right, 90, 15, "error 3", 10, Colour::Zero(), Align::Right);
  EXPECT_EQ(left.pixels, right.pixels);
}

}  // namespace
}  // namespace batten
