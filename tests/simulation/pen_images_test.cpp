#include "batten/simulation/pen_images.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

Camera small_sensor() {
  Camera camera;
  camera.width = 96;
  camera.height = 64;
  camera.fx = camera.fy = 90;
  camera.cx = 48;
  camera.cy = 32;
  return camera;
}

constexpr AmbientLight kEven{.level = 20, .slope = 0, .patch = 0, .hot_pixels = 0};

// An even image shows the sensor: the mean is the level, the variance that of reading, shot noise and
// rounding.
TEST(PenImage, HasTheNoiseOfItsSensor) {
  const GreyImage image = pen_image(small_sensor(), {}, 1, 0, kEven, {2, 0.25});
  double sum = 0, squares = 0;
  for (const std::uint8_t level : image.pixels) {
    sum += level;
    squares += level * level;
  }
  const auto n = static_cast<double>(image.pixels.size());
  EXPECT_NEAR(sum / n, 20 + 0.25 * 0 + 0.71 * kEven.slope, 4 * 3 / std::sqrt(n));
  EXPECT_NEAR(squares / n - sum * sum / n / n, 4 + 0.25 * 20 + 1.0 / 12, 0.6);
}

// A Gaussian of height h and width s holds the light 2 π h s², wherever in a pixel it lies and however it
// moved.
TEST(PenImage, KeepsTheLightOfAMovingLed) {
  const double s = 1.3, h = 150;
  for (const double shift : {0.0, 0.3, 0.5}) {
    SeenLight light{SeenLight::Kind::Led, {}, s, h};
    for (int k = 0; k < 5; ++k) light.way.emplace_back(40.5 + shift + 0.4 * k, 30.5);
    const GreyImage image = pen_image(small_sensor(), {light}, 1, 0, kEven, {0, 0});
    double sum = 0, moment = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        sum += image.at(x, y) - 20;
        moment += (image.at(x, y) - 20) * (x + 0.5);
      }
    EXPECT_NEAR(sum, 2 * kPi * h * s * s, 20);
    EXPECT_NEAR(moment / sum, 41.3 + shift, 0.03);
  }
}

TEST(PenImage, ClipsTheSunAndRepeatsItself) {
  const SeenLight sun{SeenLight::Kind::Sun, {{50, 30}}, 8, 0};
  const GreyImage image = pen_image(small_sensor(), {sun}, 4, 2);
  EXPECT_EQ(image.at(50, 30), 255);
  EXPECT_LT(image.at(5, 5), 100);
  EXPECT_EQ(image.pixels, pen_image(small_sensor(), {sun}, 4, 2).pixels);
  EXPECT_NE(image.pixels, pen_image(small_sensor(), {sun}, 4, 3).pixels) << "noise of another frame";
}

}  // namespace
}  // namespace batten
