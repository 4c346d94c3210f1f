#pragma once
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/grey_image.hpp"

// Private to the room: a Gaussian fitted to the image of a light.
namespace batten::detail {

/// A rectangle of pixels, ends included.
struct PixelBox {
  int left = 0, top = 0, right = -1, bottom = -1;

  bool contains(int x, int y) const { return x >= left && x <= right && y >= top && y <= bottom; }
};

/// Where a fit begins.
struct SpotGuess {
  Eigen::Vector2d centre;
  double sigma = 1;  ///< pixels
  double peak = 0;   ///< above the background, grey levels
};

struct FittedSpot {
  Eigen::Vector2d centre;
  Eigen::Matrix2d covariance;  ///< of the centre, pixels²
  double sigma = 0;            ///< geometric mean of both axes, pixels
  double elongation = 1;       ///< longest by shortest axis
  double peak = 0, peak_sigma = 0;
  double misfit = 0;  ///< root mean square of the residuals within two sigma, grey levels
  bool cut = false;   ///< the border of the image comes nearer than two sigma
};

/// What the fit knows of the sensor.
struct PixelNoise {
  double read = 1;  ///< standard deviation where it is dark, grey levels
  double shot = 0;  ///< variance per grey level of signal
};

/// Fits a Gaussian to the pixels round a guess. Nothing where the fit fails: too few pixels that are not
/// clipped, no peak, a width without bounds.
/// @param others  boxes of other spots, whose pixels are left out
std::optional<FittedSpot> fit_spot(const GreyImage& image, const SpotGuess& guess, const PixelNoise& noise,
                                   const std::vector<PixelBox>& others);

}  // namespace batten::detail
