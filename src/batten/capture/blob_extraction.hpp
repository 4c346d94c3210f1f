#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/camera/blobs.hpp"
#include "batten/camera/grey_image.hpp"

namespace batten {

/// What an image of a light-emitting diode looks like. The defaults take any small round spot.
struct BlobExtractionOptions {
  /// A pixel belongs to a blob where it is this many standard deviations of the image's own noise above its
  /// surroundings, 3 to 50. Lower finds fainter LEDs, and more that are none.
  double threshold = 5;
  double shot = 0.15;        ///< variance per grey level of signal, at least 0: a property of the sensor
  double least_sigma = 0.4;  ///< of the Gaussian, pixels, above 0: below are single hot pixels
  double largest_sigma = 8;  ///< pixels: above are lamps and the sun
  /// Longest by shortest axis, at least 1: above are smears of motion, streaks and two blobs in one. Two that
  /// are twice their sigma apart have 1.4; a pen at 1 m/s and 0.6 m has 1.1 with an exposure of 2 ms.
  double largest_elongation = 1.35;
  /// Amplitude, grey levels, extrapolated where pixels are clipped: above shines no LED.
  double largest_peak = 1500;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// For LEDs of a radius (metres) no nearer than that (metres) to a camera: what is larger is none.
BlobExtractionOptions blob_extraction_for(const Camera& camera, double nearest = 0.2,
                                          double led_radius = 2.5e-3);

/// Bright spots that were left out.
struct RefusedBlobs {
  long cut = 0;     ///< by the border of the image, their centre cannot be told
  long size = 0;    ///< hot pixels, lamps, the sun
  long shape = 0;   ///< not round, not Gaussian, two in one
  long bright = 0;  ///< brighter than any LED

  long total() const { return cut + size + shape + bright; }
};

/// The blobs of an image and how it was exposed.
struct BlobExtraction {
  std::vector<Blob> blobs;  ///< from top to bottom
  RefusedBlobs refused;
  double background = 0;  ///< median of the image, grey levels
  double noise = 0;       ///< its standard deviation in a dark place, grey levels
  double clipped = 0;     ///< share of the pixels that are white
};

/// Finds small round lights. The background and its noise are those of tiles of 64 × 64 pixels (median, and
/// its distance to the sixth of the darkest, which lights do not move); connected pixels above it by
/// `threshold` are one spot each; a Gaussian integrated over pixels (centre, amplitude, three numbers of its
/// shape) is fitted by weighted least squares to the pixels around each, less the plane through the rim of
/// its window, clipped pixels left out. The covariance is the inverse normal matrix, times χ² per degree of
/// freedom where that exceeds 1. Pure, serial, some ns a pixel.
/// @throws InvalidInput on bad options and an image whose pixels are not width × height.
BlobExtraction extract_blobs(const GreyImage& image, const BlobExtractionOptions& options = {});

}  // namespace batten
