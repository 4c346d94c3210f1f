#include "batten/render/image.hpp"

#include <cstring>

#include <gtest/gtest.h>
#include <png.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

// Read back by the PNG library's own reader.
TEST(EncodePng, KeepsEveryPixel) {
  Image image(7, 5, hex_colour(0x102030));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<std::uint8_t>(37 * i);
  const std::string bytes = encode_png(image);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()));
  EXPECT_EQ(header.width, 7U);
  EXPECT_EQ(header.height, 5U);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(header));
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr));
  EXPECT_EQ(pixels, image.pixels);
}

TEST(Image, PastesOnlyWhatLiesInside) {
  Image image(4, 4, hex_colour(0x000000));
  image.paste(Image(4, 4, hex_colour(0xffffff)), 2, -2);
  int white = 0;
  for (const std::uint8_t byte : image.pixels) white += byte == 255 ? 1 : 0;
  EXPECT_EQ(white, 3 * 2 * 2);
  image.paste(Image(2, 2, hex_colour(0xffffff)), 10, 10);
  EXPECT_THROW(Image(0, 3, Colour::Zero()), InvalidInput);
  EXPECT_THROW(Image(20000, 3, Colour::Zero()), InvalidInput);
}

TEST(Image, BlendsInLinearLight) {
  Image image(1, 1, Colour::Zero());
  image.blend(0, 0, Colour::Ones(), 0.5F);
  EXPECT_EQ(image.pixels[0], 188);  // sRGB of half the light
  image.blend(5, 5, Colour::Ones(), 1);
}

}  // namespace
}  // namespace batten
