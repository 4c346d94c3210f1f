#pragma once
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/grey_image.hpp"

// Where two dark and two bright squares meet; not part of the library's interface.
namespace batten::detail {

/// A blurred image. Places are pixels from the outer corner of the first one.
class SmoothImage {
 public:
  /// @param sigma of the Gaussian, pixels; at least 0.5.
  SmoothImage(const GreyImage& image, double sigma);

  int width() const { return width_; }
  int height() const { return height_; }
  double sigma() const { return sigma_; }
  float at(int x, int y) const {
    return values_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }
  /// Bilinear between pixel centres; the border goes on outside.
  double sample(const Eigen::Vector2d& place) const;

 private:
  int width_, height_;
  double sigma_;
  std::vector<float> values_;
};

struct SaddlePoint {
  Eigen::Vector2d place;
  /// Half the difference of bright and dark that an ideal corner of this curvature has, grey levels: its
  /// mixed derivative is contrast · 2 / (π σ²). Blur in the image lessens it.
  double contrast = 0;
};

/// The saddle point near a place, to a fraction of a pixel: that of a quadric fitted to a round window, which
/// is moved until it is centred. Nothing where there is none within 1.5 windows.
/// @param radius of the window, pixels.
std::optional<SaddlePoint> saddle_near(const SmoothImage& image, const Eigen::Vector2d& place, double radius);

/// All saddle points of at least `contrast`, strongest first.
std::vector<SaddlePoint> saddle_points(const SmoothImage& image, double contrast);

}  // namespace batten::detail
