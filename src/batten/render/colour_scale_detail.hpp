#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/render/colour.hpp"
#include "batten/render/image.hpp"
#include "batten/render/palette_detail.hpp"

// Values as colours, and the bar that explains them. Private to the room.
namespace batten::detail {

/// Which values take which colours.
struct ColourScale {
  double low = 0, high = 1;
  bool diverging = false;
  std::string title;  ///< above the bar
  std::string note;   ///< below the bar

  /// Grey for values that are not finite.
  Colour colour(double value) const {
    if (!std::isfinite(value)) return kGrey;
    const double t = (value - low) / (high - low);
    return diverging ? diverging_colour(t) : sequential_colour(t);
  }
};

/// Colours looked up per sample: the conversion from Lab is too slow there.
class ColourTable {
 public:
  explicit ColourTable(const ColourScale& scale)
      : low_(scale.low), factor_((kSize - 1) / (scale.high - scale.low)) {
    for (int i = 0; i < kSize; ++i) table_.push_back(scale.colour(scale.low + i / factor_));
  }
  Colour operator()(double value) const {
    if (!std::isfinite(value)) return kGrey;
    return table_[static_cast<std::size_t>(std::clamp((value - low_) * factor_ + 0.5, 0.0, kSize - 1.0))];
  }

 private:
  static constexpr int kSize = 1024;
  double low_, factor_;
  std::vector<Colour> table_;
};

/// From 0 to `range`, or where that is 0 to the value that one in a hundred is larger than; `unit` above the
/// bar.
ColourScale error_scale(const Eigen::VectorXd& values, const std::string& unit, double range);
/// Even about 0, to `range`, or where that is 0 to the size that three in a hundred are larger than.
ColourScale curvature_scale(const Eigen::VectorXd& values, const std::string& title, double range);
/// Round numbers between the ends of a scale, some five of them. @pre low < high.
std::vector<double> ticks(double low, double high);

/// Pixels that the bar takes on the right of a picture.
double bar_width(int width, int height);
void draw_bar(Image& image, const ColourScale& scale);

}  // namespace batten::detail
