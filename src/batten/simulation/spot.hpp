#pragma once
#include <Eigen/Core>

namespace batten {

/// The image of a small light: a Gaussian of amplitude `peak` integrated over square pixels, on a sensor with
/// read noise, shot noise, rounding and clipping.
struct Spot {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< pixels
  double sigma = 1;                                  ///< of the Gaussian, pixels, above 0
  double peak = 0;                                   ///< grey levels at the centre before clipping
};

/// Noise of a sensor with grey levels 0 to 255.
struct SensorNoise {
  double read = 1.5;   ///< standard deviation, grey levels
  double shot = 0.15;  ///< variance per grey level of signal
};

/// Grey levels that a spot adds to the pixel whose corner nearest to the origin is (column, row).
/// @param by_centre  where not null: its derivative by the centre
double grey_level(const Spot& spot, int column, int row, Eigen::Vector2d* by_centre = nullptr);

/// The Cramér–Rao bound on the centre of a spot whose amplitude and width are known: the inverse of its
/// Fisher information, pixels². Clipped pixels tell nothing. Infinite (1e6 on the diagonal) where nothing is
/// left.
Eigen::Matrix2d centre_bound(const Spot& spot, const SensorNoise& noise);

}  // namespace batten
