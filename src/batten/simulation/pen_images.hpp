#pragma once
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/camera.hpp"
#include "batten/camera/grey_image.hpp"
#include "batten/simulation/spot.hpp"

namespace batten {

/// A light as one camera sees it during one exposure.
struct SeenLight {
  enum class Kind {
    Led,   ///< Gaussian of `sigma`; mirrored ones too
    Lamp,  ///< the same, larger, with a streak of glare beside it
    Sun,   ///< a white disc of radius `sigma` with a ragged edge
  };
  Kind kind = Kind::Led;
  std::vector<Eigen::Vector2d> way;  ///< pixels, at equal steps of the exposure; at least one
  double sigma = 1;                  ///< pixels
  double peak = 0;                   ///< grey levels where it rests, before clipping
};

/// Room light on a sensor: what an image without lights looks like.
struct AmbientLight {
  double level = 10;  ///< grey levels, of the darkest place
  double slope = 8;   ///< added from one side to the other
  double patch = 15;  ///< of a bright place on a wall, at its middle
  int hot_pixels = 6;
};

/// Draws what a camera sees: lights, moved during the exposure, on the light of the room, with shot noise,
/// read noise, pixels that are always bright, rounding to whole grey levels and clipping at 255.
/// @param stream  of the noise; the light of the room and hot pixels depend on `seed` alone
/// @pre the seen lights have a way. Some 5 ns a pixel.
GreyImage pen_image(const Camera& camera, const std::vector<SeenLight>& lights, std::uint64_t seed,
                    std::uint64_t stream, const AmbientLight& ambient = {}, const SensorNoise& noise = {});

}  // namespace batten
