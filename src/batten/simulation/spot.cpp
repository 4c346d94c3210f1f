#include "batten/simulation/spot.hpp"

#include <cmath>

#include <Eigen/LU>

namespace batten {

namespace {

constexpr double kRoundingVariance = 1.0 / 12;  // of a value rounded to whole grey levels
constexpr double kWhiteLevel = 255;

/// ∫ of exp(−(t − c)²/(2σ²)) over one pixel from `from`, and its derivative by c.
double integral(double from, double centre, double sigma, double* derivative) {
  const double low = (from - centre) / sigma, high = (from + 1 - centre) / sigma;
  if (derivative) *derivative = std::exp(-low * low / 2) - std::exp(-high * high / 2);
  return sigma * std::sqrt(std::acos(-1.0) / 2) *
         (std::erf(high / std::sqrt(2.0)) - std::erf(low / std::sqrt(2.0)));
}

}  // namespace

double grey_level(const Spot& spot, int column, int row, Eigen::Vector2d* by_centre) {
  double along_u = 0, along_v = 0;
  const double u = integral(column, spot.centre.x(), spot.sigma, &along_u);
  const double v = integral(row, spot.centre.y(), spot.sigma, &along_v);
  if (by_centre) *by_centre = spot.peak * Eigen::Vector2d(along_u * v, u * along_v);
  return spot.peak * u * v;
}

Eigen::Matrix2d centre_bound(const Spot& spot, const SensorNoise& noise) {
  const int radius = static_cast<int>(std::ceil(4 * spot.sigma)) + 1;
  const int column = static_cast<int>(std::floor(spot.centre.x()));
  const int row = static_cast<int>(std::floor(spot.centre.y()));
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity() * 1e-6;
  for (int y = row - radius; y <= row + radius; ++y)
    for (int x = column - radius; x <= column + radius; ++x) {
      Eigen::Vector2d slope;
      const double level = grey_level(spot, x, y, &slope);
      if (level >= kWhiteLevel) continue;
      information +=
          slope * slope.transpose() / (noise.read * noise.read + kRoundingVariance + noise.shot * level);
    }
  return information.inverse();
}

}  // namespace batten
