#include "batten/render/colour.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(Colour, BytesSurviveTheWayToLinearLightAndBack) {
  for (int byte = 0; byte < 256; ++byte)
    EXPECT_EQ(srgb_byte(linear_value(static_cast<std::uint8_t>(byte))), byte);
  EXPECT_EQ(srgb_byte(-1), 0);
  EXPECT_EQ(srgb_byte(2), 255);
}

TEST(Colour, SequentialMapGetsDarkerAllTheWay) {
  for (int i = 0; i < 256; ++i)
    EXPECT_LT(luminance(sequential_colour((i + 1) / 256.0)), luminance(sequential_colour(i / 256.0))) << i;
}

TEST(Colour, DivergingMapIsBrightestInTheMiddle) {
  for (int i = 0; i < 128; ++i) {
    EXPECT_LT(luminance(diverging_colour(i / 256.0)), luminance(diverging_colour((i + 1) / 256.0))) << i;
    EXPECT_LT(luminance(diverging_colour(1 - i / 256.0)), luminance(diverging_colour(1 - (i + 1) / 256.0)))
        << i;
  }
  EXPECT_GT(diverging_colour(0)[2], diverging_colour(0)[0]);
  EXPECT_GT(diverging_colour(1)[0], diverging_colour(1)[2]);
  EXPECT_EQ(diverging_colour(7), diverging_colour(1));
}

}  // namespace
}  // namespace batten
