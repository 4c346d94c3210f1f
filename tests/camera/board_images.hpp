#pragma once
#include "camera/boards.hpp"

#include <cmath>

#include "batten/camera/grey_image.hpp"

namespace batten::test {

/// How a picture of a board is taken.
struct PictureOptions {
  double bright = 200, dark = 40;  ///< grey levels of the squares; the margin is bright, what lies around 110
  double noise = 1.5;              ///< grey levels
  int blur = 0;                    ///< radius of a box blur applied twice, pixels: σ² = 2 r (r + 1) / 3
  double missing = 0;              ///< share of the board, from its left, that something grey hides
  std::uint64_t seed = 1;
};

/// The picture that a camera takes of a board at X = R · board + t, averaged over 4 × 4 rays per pixel. The
/// square beyond the first corner is dark; the board has one more square along each side than corners, and a
/// margin of one.
inline GreyImage picture_of(const Camera& camera, const Board& board, const Eigen::Matrix3d& R,
                            const Eigen::Vector3d& t, const PictureOptions& options = {}) {
  constexpr int kRays = 4;
  const int w = camera.width, h = camera.height;
  std::vector<double> values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  const auto seen = [&](double u, double v) {
    const auto ray = undistort(camera, {u, v});
    if (!ray) return 110.0;
    const Eigen::Vector3d direction = R.transpose() * ray->homogeneous(), centre = -(R.transpose() * t);
    const double s = -centre.z() / direction.z();
    const double x = (centre.x() + s * direction.x()) / board.square,
                 y = (centre.y() + s * direction.y()) / board.square;
    if (x < -2 || y < -2 || x > board.columns + 1 || y > board.rows + 1) return 110.0;
    if (x < options.missing * board.columns && options.missing > 0) return 110.0;
    if (x < -1 || y < -1 || x > board.columns || y > board.rows) return options.bright;
    const int parity = static_cast<int>(std::floor(x) + std::floor(y) + 4) % 2;
    return parity == 0 ? options.dark : options.bright;
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      double sum = 0;
      for (int i = 0; i < kRays; ++i)
        for (int k = 0; k < kRays; ++k) sum += seen(x + (i + 0.5) / kRays, y + (k + 0.5) / kRays);
      values[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
          sum / (kRays * kRays);
    }
  const auto at_clamped = [&](const std::vector<double>& from, int x, int y) {
    return from[static_cast<std::size_t>(std::clamp(y, 0, h - 1)) * static_cast<std::size_t>(w) +
                static_cast<std::size_t>(std::clamp(x, 0, w - 1))];
  };
  for (int pass = 0; pass < (options.blur > 0 ? 4 : 0); ++pass) {
    const std::vector<double> from = values;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        double sum = 0;
        for (int i = -options.blur; i <= options.blur; ++i)
          sum += pass % 2 == 0 ? at_clamped(from, x + i, y) : at_clamped(from, x, y + i);
        values[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
            sum / (2 * options.blur + 1);
      }
  }
  Random random(options.seed);
  GreyImage image{w, h, {}};
  for (const double value : values)
    image.pixels.push_back(static_cast<std::uint8_t>(
        std::clamp(std::lround(value + options.noise * random.normal()), 0L, 255L)));
  return image;
}

}  // namespace batten::test
