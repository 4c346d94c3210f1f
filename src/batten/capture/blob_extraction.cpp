#include "batten/capture/blob_extraction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "batten/capture/spot_fit_detail.hpp"
#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

using namespace detail;

namespace {

constexpr int kTile = 64;            // pixels, of the tiles that have a background of their own
constexpr int kSparse = 2;           // every second row and column tells it
constexpr double kLeastNoise = 0.3;  // grey levels: of rounding alone
constexpr int kLeastStep = 3;        // grey levels that a pixel must be above its background
constexpr double kSixth = 0.1587;    // of a normal distribution lies below one standard deviation
constexpr double kFaintest = 6;      // standard deviations of its amplitude by which a spot must shine
constexpr double kMisfit = 0.15;     // of its amplitude, that residuals of a Gaussian may have
constexpr double kCloseness = 4;     // sigma between two spots, below which neither is told apart
constexpr int kClippedLevel = 255;
constexpr double kBlur = 1;  // pixels, of a lens out of focus

using Histogram = std::array<std::uint32_t, 256>;

/// The level below which a share of the pixels lies, between whole levels by a line.
double level_below(const Histogram& histogram, std::uint32_t n, double share) {
  const double wanted = share * n;
  double below = 0;
  for (std::size_t level = 0; level < histogram.size(); ++level) {
    const double here = histogram[level];
    if (below + here >= wanted && here > 0) return static_cast<double>(level) - 0.5 + (wanted - below) / here;
    below += here;
  }
  return 255;
}

struct ImageTile {
  double background = 0, noise = 0;
  int threshold = 0;  // pixels above it belong to spots
};

/// Background, noise and threshold of an image, tile by tile.
class ImageTiles {
 public:
  ImageTiles(const GreyImage& image, double threshold, BlobExtraction& result)
      : columns_((image.width + kTile - 1) / kTile) {
    const int rows = (image.height + kTile - 1) / kTile;
    Histogram whole{};
    std::uint32_t n_whole = 0;
    std::vector<double> noises;
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns_; ++column) {
        Histogram histogram{};
        std::uint32_t n = 0;
        const int bottom = std::min(image.height, (row + 1) * kTile);
        const int right = std::min(image.width, (column + 1) * kTile);
        for (int y = row * kTile; y < bottom; y += kSparse)
          for (int x = column * kTile; x < right; x += kSparse, ++n) ++histogram[image.at(x, y)];
        for (std::size_t level = 0; level < whole.size(); ++level) whole[level] += histogram[level];
        n_whole += n;
        ImageTile tile;
        tile.background = level_below(histogram, n, 0.5);
        // Lights lift the bright half; the dark one tells the noise.
        tile.noise = std::max(kLeastNoise, tile.background - level_below(histogram, n, kSixth));
        tile.threshold = static_cast<int>(
            std::ceil(tile.background + std::max<double>(kLeastStep, threshold * tile.noise)));
        tiles_.push_back(tile);
        noises.push_back(tile.noise);
      }
    result.background = level_below(whole, n_whole, 0.5);
    const auto middle = noises.begin() + static_cast<std::ptrdiff_t>(noises.size() / 2);
    std::nth_element(noises.begin(), middle, noises.end());
    result.noise = *middle;
    result.clipped = static_cast<double>(whole[kClippedLevel]) / n_whole;
  }

  const ImageTile& at(int x, int y) const {
    return tiles_[static_cast<std::size_t>(y / kTile) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(x / kTile)];
  }

 private:
  int columns_;
  std::vector<ImageTile> tiles_;
};

/// Pixels of one row that are bright, ends included.
struct BrightRun {
  int y, first, last;
};

/// Connected bright pixels.
struct BrightRegion {
  PixelBox box;
  long area = 0;
  double weight = 0;  // sum of levels above the background
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  int brightest = 0;
};

std::vector<BrightRun> bright_runs(const GreyImage& image, const ImageTiles& tiles) {
  std::vector<BrightRun> runs;
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* row =
        image.pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
    int open = -1;  // where a run has begun
    for (int from = 0; from < image.width; from += kTile) {
      const int to = std::min(image.width, from + kTile), threshold = tiles.at(from, y).threshold;
      std::uint8_t most = 0;
      for (int x = from; x < to; ++x) most = std::max(most, row[x]);
      if (most <= threshold && open < 0) continue;
      for (int x = from; x < to; ++x) {
        const bool bright = row[x] > threshold;
        if (bright && open < 0) open = x;
        if (!bright && open >= 0) {
          runs.push_back({y, open, x - 1});
          open = -1;
        }
      }
    }
    if (open >= 0) runs.push_back({y, open, image.width - 1});
  }
  return runs;
}

/// Joins runs that touch, diagonally too.
std::vector<BrightRegion> bright_regions(const GreyImage& image, const ImageTiles& tiles) {
  const std::vector<BrightRun> runs = bright_runs(image, tiles);
  DisjointSets sets(static_cast<int>(runs.size()));
  for (std::size_t i = 0, above = 0; i < runs.size(); ++i) {
    while (runs[above].y < runs[i].y - 1 ||
           (runs[above].y == runs[i].y - 1 && runs[above].last < runs[i].first - 1))
      ++above;
    for (std::size_t k = above; k < i && runs[k].y == runs[i].y - 1 && runs[k].first <= runs[i].last + 1; ++k)
      sets.unite(static_cast<int>(k), static_cast<int>(i));
  }
  const std::vector<int> labels = sets.labels();
  std::vector<BrightRegion> regions(static_cast<std::size_t>(sets.n_sets()));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    BrightRegion& region = regions[at(labels[i])];
    if (region.area == 0) region.box = {runs[i].first, runs[i].y, runs[i].last, runs[i].y};
    region.box.left = std::min(region.box.left, runs[i].first);
    region.box.right = std::max(region.box.right, runs[i].last);
    region.box.bottom = runs[i].y;
    for (int x = runs[i].first; x <= runs[i].last; ++x) {
      const int level = image.at(x, runs[i].y);
      const double above = level - tiles.at(x, runs[i].y).background;
      ++region.area;
      region.weight += above;
      region.moment += above * Eigen::Vector2d(x + 0.5, runs[i].y + 0.5);
      region.brightest = std::max(region.brightest, level);
    }
  }
  return regions;
}

bool touches_border(const PixelBox& box, const GreyImage& image) {
  return box.left == 0 || box.top == 0 || box.right == image.width - 1 || box.bottom == image.height - 1;
}

SpotGuess guess_of(const BrightRegion& region, const ImageTile& tile) {
  SpotGuess guess;
  guess.centre = region.moment / region.weight;
  guess.peak = region.brightest - tile.background;
  if (region.brightest >= kClippedLevel) guess.peak *= 1.5;  // what is clipped was higher
  // A Gaussian lies above the threshold on an area of 2 π σ² ln(peak / threshold).
  const double ratio = guess.peak / std::max(1.0, tile.threshold - tile.background);
  const double area = static_cast<double>(region.area);
  guess.sigma = std::sqrt(std::max(0.25, area / (2 * kPi * std::log(std::max(1.3, ratio)))));
  return guess;
}

/// Boxes of other regions near this one, grown by the dim skirt that lies below the threshold.
std::vector<PixelBox> boxes_near(const std::vector<BrightRegion>& regions, std::size_t which, double reach) {
  std::vector<PixelBox> boxes;
  const PixelBox& own = regions[which].box;
  const int far = static_cast<int>(std::ceil(reach));
  for (std::size_t i = 0; i < regions.size(); ++i) {
    PixelBox box = regions[i].box;
    if (i == which || box.left > own.right + far || box.right < own.left - far ||
        box.top > own.bottom + far || box.bottom < own.top - far)
      continue;
    const int skirt = 1 + (box.right - box.left) / 3;
    boxes.push_back({box.left - skirt, box.top - skirt, box.right + skirt, box.bottom + skirt});
  }
  return boxes;
}

/// Two spots whose Gaussians overlap pull at each other: neither is kept.
void drop_overlapping(std::vector<FittedSpot>& spots, RefusedBlobs& refused) {
  std::vector<bool> overlaps(spots.size(), false);
  for (std::size_t i = 0; i < spots.size(); ++i)
    for (std::size_t k = i + 1; k < spots.size(); ++k)
      if ((spots[i].centre - spots[k].centre).norm() < kCloseness * std::max(spots[i].sigma, spots[k].sigma))
        overlaps[i] = overlaps[k] = true;
  std::vector<FittedSpot> kept;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (overlaps[i])
      ++refused.shape;
    else
      kept.push_back(spots[i]);
  }
  spots = std::move(kept);
}

/// Counts why a fit is no LED, or says that it is one.
bool is_led(const FittedSpot& spot, const ImageTile& tile, const BlobExtractionOptions& options,
            RefusedBlobs& refused) {
  if (spot.cut)
    ++refused.cut;
  else if (spot.sigma < options.least_sigma || spot.sigma > options.largest_sigma)
    ++refused.size;
  else if (spot.peak > options.largest_peak)
    ++refused.bright;
  else if (spot.elongation > options.largest_elongation ||
           spot.misfit > kMisfit * std::min<double>(spot.peak, kClippedLevel) + 2 * tile.noise ||
           spot.peak < kFaintest * spot.peak_sigma)
    ++refused.shape;
  else
    return true;
  return false;
}

}  // namespace

std::optional<std::string> BlobExtractionOptions::problem() const {
  const auto range = [](const char* field, double value, const char* expected) {
    return concat(field, " is ", value, "; expected ", expected);
  };
  if (!(threshold >= 3 && threshold <= 50)) return range("threshold", threshold, "3 to 50");
  if (!(shot >= 0 && shot <= 100)) return range("shot", shot, "0 to 100");
  if (!(least_sigma > 0)) return range("least_sigma", least_sigma, "pixels above 0");
  if (!(largest_sigma > least_sigma && largest_sigma <= 50))
    return range("largest_sigma", largest_sigma, "more than least_sigma, at most 50");
  if (!(largest_elongation >= 1)) return range("largest_elongation", largest_elongation, "at least 1");
  if (!(largest_peak > 0)) return range("largest_peak", largest_peak, "grey levels above 0");
  return {};
}

BlobExtractionOptions blob_extraction_for(const Camera& camera, double nearest, double led_radius) {
  BlobExtractionOptions options;
  // The disc of radius r at distance z has the variance (f r / z)² / 4 along an axis.
  const double disc = std::max(camera.fx, camera.fy) * led_radius / nearest / 2;
  options.largest_sigma = std::min(50.0, std::hypot(kBlur, disc));
  return options;
}

BlobExtraction extract_blobs(const GreyImage& image, const BlobExtractionOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  if (image.width < 1 || image.height < 1 ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height))
    throw InvalidInput(concat("the image has ", image.pixels.size(), " pixels; expected ", image.width, " x ",
                              image.height));
  BlobExtraction result;
  const ImageTiles tiles(image, options.threshold, result);
  const std::vector<BrightRegion> regions = bright_regions(image, tiles);
  std::vector<FittedSpot> spots;
  const double widest = 2 * (3.5 * options.largest_sigma + 1);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const BrightRegion& region = regions[i];
    if (region.box.right - region.box.left > widest || region.box.bottom - region.box.top > widest) {
      ++result.refused.size;
      continue;
    }
    if (region.area < 2) {  // the noise of one pixel
      ++result.refused.size;
      continue;
    }
    if (touches_border(region.box, image)) {
      ++result.refused.cut;
      continue;
    }
    const ImageTile& tile = tiles.at((region.box.left + region.box.right) / 2, region.box.top);
    const SpotGuess guess = guess_of(region, tile);
    const auto spot =
        fit_spot(image, guess, {tile.noise, options.shot}, boxes_near(regions, i, 4 * guess.sigma + 2));
    if (!spot)
      ++result.refused.shape;
    else if (is_led(*spot, tile, options, result.refused))
      spots.push_back(*spot);
  }
  drop_overlapping(spots, result.refused);
  for (const FittedSpot& spot : spots) result.blobs.push_back({spot.centre, spot.covariance});
  return result;
}

}  // namespace batten
