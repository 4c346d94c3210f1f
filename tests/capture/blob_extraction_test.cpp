#include "batten/capture/blob_extraction.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/simulation/pen_images.hpp"

namespace batten {
namespace {

Camera sensor(int width = 320, int height = 256) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 300;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

SeenLight led(double u, double v, double sigma, double peak) {
  return {SeenLight::Kind::Led, {{u, v}}, sigma, peak};
}

constexpr AmbientLight kDark{.level = 10, .slope = 0, .patch = 0, .hot_pixels = 0};

struct CentreErrors {
  double by_bound = 0;    // rms error by the rms of the bound
  double chi_square = 0;  // by the covariance handed on, per number
  long found = 0, missed = 0, false_ones = 0;
};

/// Many LEDs on a grid, each at a random place within its pixel.
CentreErrors centre_errors(double sigma, double peak, int images) {
  CentreErrors result;
  double squares = 0, bounds = 0;
  Random random(17);
  for (int k = 0; k < images; ++k) {
    std::vector<SeenLight> lights;
    for (int i = 0; i < 30; ++i)
      lights.push_back(
          led(30 + 50 * (i % 6) + random.uniform(), 30 + 45 * (i / 6) + random.uniform(), sigma, peak));
    const GreyImage image = pen_image(sensor(), lights, 5, static_cast<std::uint64_t>(k), kDark);
    const std::vector<Blob> blobs = extract_blobs(image).blobs;
    std::size_t matched = 0;
    for (const SeenLight& light : lights) {
      // The light of the room adds its shot noise to that of reading.
      const SensorNoise noise{std::sqrt(1.5 * 1.5 + 0.15 * kDark.level), 0.15};
      const Eigen::Matrix2d bound = centre_bound({light.way[0], sigma, peak}, noise);
      for (const Blob& blob : blobs) {
        const Eigen::Vector2d off = blob.pixel - light.way[0];
        if (off.norm() > 1) continue;
        ++matched;
        squares += off.squaredNorm();
        bounds += bound.trace();
        result.chi_square += off.dot(blob.covariance.inverse() * off) / 2;
      }
    }
    result.found += static_cast<long>(matched);
    result.missed += static_cast<long>(lights.size() - matched);
    result.false_ones += static_cast<long>(blobs.size() - matched);
  }
  result.by_bound = std::sqrt(squares / bounds);
  result.chi_square /= static_cast<double>(result.found);
  return result;
}

// The rows of the table of blob centres: width and height of spots, one of them clipped.
TEST(ExtractBlobs, CentresReachTheCramerRaoBound) {
  const double kinds[][2] = {{0.55, 200}, {0.9, 60}, {0.9, 200}, {1.5, 200}, {2.6, 180}, {0.9, 600}};
  for (const auto& [sigma, peak] : kinds) {
    const CentreErrors errors = centre_errors(sigma, peak, 8);
    EXPECT_LT(errors.by_bound, 1.1) << sigma << " " << peak;
    EXPECT_NEAR(errors.chi_square, 1, 0.2) << sigma << " " << peak << ": the covariance is no true one";
    EXPECT_EQ(errors.missed, 0) << sigma << " " << peak;
    EXPECT_EQ(errors.false_ones, 0) << sigma << " " << peak;
  }
}

TEST(ExtractBlobs, TellsLedsFromLampsSunHotPixelsAndStreaks) {
  const std::vector<SeenLight> lights = {led(60, 60, 1.5, 150),
                                         led(200, 180, 2.5, 150),
                                         {SeenLight::Kind::Lamp, {{120, 200}}, 12, 400},
                                         {SeenLight::Kind::Sun, {{220, 60}}, 15, 0}};
  const BlobExtraction found = extract_blobs(pen_image(sensor(), lights, 3, 0), {.largest_sigma = 5});
  ASSERT_EQ(found.blobs.size(), 2u);
  EXPECT_LT((found.blobs[0].pixel - Eigen::Vector2d(60, 60)).norm(), 0.1);
  EXPECT_LT((found.blobs[1].pixel - Eigen::Vector2d(200, 180)).norm(), 0.1);
  EXPECT_GE(found.refused.size, 2 + 6) << "lamp, sun and six hot pixels";
}

TEST(ExtractBlobs, RefusesWhatIsMergedSmearedOrCut) {
  const auto found = [](const std::vector<SeenLight>& lights) {
    return extract_blobs(pen_image(sensor(), lights, 1, 0, kDark));
  };
  for (const double distance : {4.0, 5.0, 6.0, 7.5})
    EXPECT_TRUE(found({led(100, 100, 2, 150), led(100 + distance, 100, 2, 120)}).blobs.empty()) << distance;
  EXPECT_EQ(found({led(100, 100, 2, 150), led(112, 100, 2, 120)}).blobs.size(), 2u) << "six sigma apart";
  SeenLight smear{SeenLight::Kind::Led, {}, 1, 300};
  for (int k = 0; k < 9; ++k) smear.way.emplace_back(100 + k, 100 + k);
  EXPECT_TRUE(found({smear}).blobs.empty());
  EXPECT_EQ(found({led(1.2, 100, 2, 200)}).refused.cut, 1);
  EXPECT_TRUE(found({led(100, 254.5, 2, 200)}).blobs.empty());
  EXPECT_EQ(found({led(12, 100, 2, 200)}).blobs.size(), 1u);
}

// A brighter or dimmer sensor with more noise needs no other setting: the threshold is the image's own.
TEST(ExtractBlobs, FindsLedsInBrightAndNoisyImages) {
  const AmbientLight bright{.level = 90, .slope = 40, .patch = 40, .hot_pixels = 0};
  const std::vector<SeenLight> lights = {led(80.3, 70.6, 1.2, 110), led(240.1, 200.2, 1.2, 110)};
  for (const double read : {1.0, 6.0})
    for (std::uint64_t seed = 1; seed < 5; ++seed) {
      const GreyImage image = pen_image(sensor(), lights, seed, 0, bright, {read, 0.15});
      const BlobExtraction found = extract_blobs(image);
      EXPECT_EQ(found.blobs.size(), 2u) << read << " " << seed;
      EXPECT_NEAR(found.noise, std::sqrt(read * read + 0.15 * 120), 0.35 * read + 1);
    }
}

TEST(ExtractBlobs, FindsNothingInImagesOfNothing) {
  for (const int level : {0, 128, 255}) {
    const GreyImage flat{200, 150, std::vector<std::uint8_t>(200 * 150, static_cast<std::uint8_t>(level))};
    const BlobExtraction found = extract_blobs(flat);
    EXPECT_TRUE(found.blobs.empty());
    EXPECT_EQ(found.clipped, level == 255 ? 1.0 : 0.0);
  }
  GreyImage rough{256, 256, std::vector<std::uint8_t>(256 * 256)};
  Random random(1);
  for (std::uint8_t& pixel : rough.pixels) pixel = static_cast<std::uint8_t>(random.below(256));
  EXPECT_TRUE(extract_blobs(rough).blobs.empty());
  EXPECT_TRUE(extract_blobs(GreyImage{1, 1, {9}}).blobs.empty());
  EXPECT_THROW(extract_blobs(GreyImage{}), InvalidInput);
  EXPECT_THROW(extract_blobs(GreyImage{4, 4, {1, 2}}), InvalidInput);
  EXPECT_THROW(extract_blobs(GreyImage{1, 1, {9}}, {.threshold = 1}), InvalidInput);
}

// Background and noise are taken from every second pixel, so that a tenth of the bound (0.03 pixels) may
// differ.
TEST(ExtractBlobs, DoesNotDependOnTheWayTheImageLies) {
  const std::vector<SeenLight> lights = {led(60.3, 60.8, 1.5, 150), led(200.1, 130.4, 2.5, 220)};
  const GreyImage image = pen_image(sensor(256, 192), lights, 3, 0, kDark);
  GreyImage turned = image;
  std::reverse(turned.pixels.begin(), turned.pixels.end());
  const std::vector<Blob> blobs = extract_blobs(image).blobs, others = extract_blobs(turned).blobs;
  ASSERT_EQ(blobs.size(), 2u);
  ASSERT_EQ(others.size(), 2u);
  EXPECT_LT((blobs[0].pixel + others[1].pixel - Eigen::Vector2d(256, 192)).norm(), 3e-3);
  EXPECT_LT((blobs[1].pixel + others[0].pixel - Eigen::Vector2d(256, 192)).norm(), 3e-3);
}

}  // namespace
}  // namespace batten
