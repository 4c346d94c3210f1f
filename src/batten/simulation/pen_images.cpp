#include "batten/simulation/pen_images.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

constexpr double kSunLevel = 2000;  // grey levels before clipping
constexpr double kRagged = 0.25;    // of the radius of a spot of the sun
constexpr int kRaggedWaves = 5;
constexpr double kReach = 4.5;        // sigma beyond which a light adds nothing
constexpr double kGlareLength = 12;   // sigma of the lamp
constexpr double kGlareShare = 0.25;  // of its peak
constexpr int kGlareSteps = 24;
constexpr double kPatchWidth = 0.12;  // of the width of the image
constexpr double kHotLevel = 120;     // grey levels on average
constexpr std::uint64_t kRoom = 301, kTable = 302, kPixels = 400;

/// Levels before noise, row by row.
struct LevelImage {
  int width, height;
  std::vector<float> levels;

  float& at(int x, int y) {
    return levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

LevelImage room_of(const Camera& camera, std::uint64_t seed, const AmbientLight& ambient) {
  Random random(seed, kRoom);
  const double heading = random.uniform(0, 2 * kPi);
  const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
  // One after the other: a compiler may draw the arguments of a call in any order.
  const double patch_y = random.uniform(0, camera.height), patch_x = random.uniform(0, camera.width);
  const Eigen::Vector2d patch(patch_x, patch_y);
  const double width = kPatchWidth * camera.width;
  LevelImage room{camera.width, camera.height, {}};
  room.levels.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  // Separable, so that no exponential is taken for every pixel.
  std::vector<double> across;
  for (int x = 0; x < camera.width; ++x)
    across.push_back(std::exp(-std::pow((x - patch.x()) / width, 2) / 2));
  for (int y = 0; y < camera.height; ++y) {
    const double down = ambient.patch * std::exp(-std::pow((y - patch.y()) / width, 2) / 2);
    for (int x = 0; x < camera.width; ++x) {
      const double side = along.x() * (static_cast<double>(x) / camera.width - 0.5) +
                          along.y() * (static_cast<double>(y) / camera.height - 0.5);
      room.at(x, y) = static_cast<float>(ambient.level + ambient.slope * (0.71 + side) +
                                         down * across[static_cast<std::size_t>(x)]);
    }
  }
  for (int k = 0; k < ambient.hot_pixels; ++k) {
    const int x = static_cast<int>(random.below(static_cast<std::uint64_t>(camera.width)));
    const int y = static_cast<int>(random.below(static_cast<std::uint64_t>(camera.height)));
    room.at(x, y) += static_cast<float>(kHotLevel * random.uniform(0.5, 1.5));
  }
  return room;
}

void add_spot(LevelImage& image, const Spot& spot) {
  const double reach = kReach * spot.sigma + 1;
  const int left = std::max(0, static_cast<int>(spot.centre.x() - reach));
  const int right = std::min(image.width - 1, static_cast<int>(spot.centre.x() + reach));
  const int top = std::max(0, static_cast<int>(spot.centre.y() - reach));
  const int bottom = std::min(image.height - 1, static_cast<int>(spot.centre.y() + reach));
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) image.at(x, y) += static_cast<float>(grey_level(spot, x, y));
}

void add_sun(LevelImage& image, const SeenLight& light, Random& random) {
  std::array<double, kRaggedWaves> phases{}, heights{};
  for (std::size_t k = 0; k < phases.size(); ++k) {
    phases[k] = random.uniform(0, 2 * kPi);
    heights[k] = kRagged * random.uniform() / static_cast<double>(k + 1);
  }
  const Eigen::Vector2d centre = light.way.front();
  const double reach = light.sigma * (1 + 2 * kRagged);
  for (int y = std::max(0, static_cast<int>(centre.y() - reach));
       y < std::min<double>(image.height, centre.y() + reach); ++y)
    for (int x = std::max(0, static_cast<int>(centre.x() - reach));
         x < std::min<double>(image.width, centre.x() + reach); ++x) {
      const Eigen::Vector2d off = Eigen::Vector2d(x + 0.5, y + 0.5) - centre;
      const double angle = std::atan2(off.y(), off.x());
      double radius = 1;
      for (std::size_t k = 0; k < phases.size(); ++k)
        radius += heights[k] * std::sin(static_cast<double>(k + 1) * angle + phases[k]);
      // Half a pixel of blur at the edge.
      const double inside = std::clamp(light.sigma * radius - off.norm() + 0.5, 0.0, 1.0);
      image.at(x, y) += static_cast<float>(kSunLevel * inside);
    }
}

void add_seen_light(LevelImage& image, const SeenLight& light, Random& random) {
  if (light.kind == SeenLight::Kind::Sun) {
    add_sun(image, light, random);
    return;
  }
  const double share = light.peak / static_cast<double>(light.way.size());
  for (const Eigen::Vector2d& place : light.way) add_spot(image, {place, light.sigma, share});
  if (light.kind != SeenLight::Kind::Lamp) return;
  const double angle = random.uniform(0, kPi), width = light.sigma / 3;
  const Eigen::Vector2d along =
      kGlareLength * light.sigma * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  for (int k = 0; k < kGlareSteps; ++k)
    add_spot(image, {light.way.front() + along * (0.7 + (k + 0.5) / kGlareSteps), width,
                     kGlareShare * light.peak * 4 / kGlareSteps});
}

/// Normal numbers of which the noise of all pixels is drawn: 65,536, of mean 0 and variance 1.
std::vector<float> normal_table(std::uint64_t seed) {
  Random random(seed, kTable);
  std::vector<double> numbers(65536);
  double sum = 0, squares = 0;
  for (double& number : numbers) {
    number = random.normal();
    sum += number;
    squares += number * number;
  }
  const auto n = static_cast<double>(numbers.size());
  const double mean = sum / n, deviation = std::sqrt(squares / n - mean * mean);
  std::vector<float> table;
  table.reserve(numbers.size());
  for (const double number : numbers) table.push_back(static_cast<float>((number - mean) / deviation));
  return table;
}

}  // namespace

GreyImage pen_image(const Camera& camera, const std::vector<SeenLight>& lights, std::uint64_t seed,
                    std::uint64_t stream, const AmbientLight& ambient, const SensorNoise& noise) {
  LevelImage levels = room_of(camera, seed, ambient);
  Random shapes(seed, kRoom + 1);  // of the sun and of glare, the same in every image
  for (const SeenLight& light : lights) add_seen_light(levels, light, shapes);
  const std::vector<float> table = normal_table(seed);
  Random random(seed, kPixels + stream);
  GreyImage image{camera.width, camera.height, {}};
  image.pixels.resize(levels.levels.size());
  std::uint64_t bits = 0;
  const auto read = static_cast<float>(noise.read * noise.read), shot = static_cast<float>(noise.shot);
  for (std::size_t i = 0; i < levels.levels.size(); ++i) {
    bits = i % 4 == 0 ? random.bits() : bits >> 16;
    const float level = levels.levels[i];
    const float noisy = level + std::sqrt(read + shot * level) * table[bits & 0xffffU];
    image.pixels[i] = static_cast<std::uint8_t>(std::clamp(noisy + 0.5F, 0.0F, 255.0F));
  }
  return image;
}

}  // namespace batten
