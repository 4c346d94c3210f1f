#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "batten/capture/spot_fit_detail.hpp"
#include "batten/core/statistics.hpp"

namespace batten::detail {

namespace {

constexpr int kWhite = 255;
constexpr double kWindow = 4;       // sigma: half of the side of the last window
constexpr double kFirstWindow = 3;  // of the first, when the width is a guess
constexpr int kFirstSteps = 5;      // Gauss–Newton steps in each
constexpr int kLastSteps = 4;
constexpr double kSettled = 1e-3;            // pixels
constexpr double kPixelVariance = 1.0 / 12;  // of a square pixel along an axis
constexpr double kPixelFourth = 1.0 / 2880;  // its fourth cumulant by 4!, with the sign changed
constexpr double kRimOutlier = 4;            // standard deviations
constexpr double kWidestSpot = 60;           // pixels, of a Gaussian that is still looked at
constexpr int kFewestPixels = 9;

/// Centre u, v; amplitude; a, b, c of the inverse Q = [a b; b c] of the covariance, pixels included.
constexpr int kNumbers = 6;
using SpotParameters = Eigen::Matrix<double, kNumbers, 1>;
using SpotNormal = Eigen::Matrix<double, kNumbers, kNumbers>;

/// The pixels of a window that count.
struct SpotPixels {
  std::vector<Eigen::Vector3d> used;  // centre of the pixel, level above the background
  double read = 0;                    // standard deviation
};

PixelBox window_of(const GreyImage& image, const Eigen::Vector2d& centre, double half) {
  const int radius = static_cast<int>(std::ceil(half)) + 1;
  const int x = static_cast<int>(std::floor(centre.x())), y = static_cast<int>(std::floor(centre.y()));
  return {std::max(0, x - radius), std::max(0, y - radius), std::min(image.width - 1, x + radius),
          std::min(image.height - 1, y + radius)};
}

/// The plane offset + slope · (pixel − centre) of least squares through the rim of a window.
struct RimPlane {
  double offset = 0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
};

RimPlane rim_plane(const std::vector<Eigen::Vector3d>& rim, const Eigen::Vector2d& centre, double noise) {
  RimPlane plane;
  if (rim.empty()) return plane;
  std::vector<double> levels;
  levels.reserve(rim.size());
  for (const Eigen::Vector3d& pixel : rim) levels.push_back(pixel.z());
  const double middle = median(levels);
  plane.offset = middle;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& pixel : rim) {
    if (std::abs(pixel.z() - middle) > kRimOutlier * noise + 1) continue;
    const Eigen::Vector3d row(1, pixel.x() - centre.x(), pixel.y() - centre.y());
    normal += row * row.transpose();
    right += pixel.z() * row;
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(normal);
  if (factor.info() != Eigen::Success) return plane;
  const Eigen::Vector3d solved = factor.solve(right);
  if (!solved.allFinite()) return plane;
  plane.offset = solved[0];
  plane.slope = solved.tail<2>();
  return plane;
}

SpotPixels pixels_of(const GreyImage& image, const PixelBox& box, const Eigen::Vector2d& centre,
                     const PixelNoise& noise, const std::vector<PixelBox>& others) {
  const auto elsewhere = [&](int x, int y) {
    return std::any_of(others.begin(), others.end(),
                       [&](const PixelBox& other) { return other.contains(x, y); });
  };
  std::vector<Eigen::Vector3d> rim;
  SpotPixels pixels;
  pixels.read = noise.read;
  for (int y = box.top; y <= box.bottom; ++y)
    for (int x = box.left; x <= box.right; ++x) {
      const int level = image.at(x, y);
      if (level >= kWhite || (!others.empty() && elsewhere(x, y))) continue;
      pixels.used.emplace_back(x + 0.5, y + 0.5, level);
      if (x == box.left || x == box.right || y == box.top || y == box.bottom)
        rim.push_back(pixels.used.back());
    }
  const RimPlane plane = rim_plane(rim, centre, noise.read);
  for (Eigen::Vector3d& pixel : pixels.used)
    pixel.z() -= plane.offset + plane.slope.dot(pixel.head<2>() - centre);
  return pixels;
}

/// What a pixel adds to the normal equations; returned are its model and weight.
struct SpotModel {
  double level = 0, weight = 0;
  SpotParameters slope;
};

SpotModel model_at(const SpotParameters& p, const Eigen::Vector3d& pixel, double read_variance, double shot) {
  const double x = pixel.x() - p[0], y = pixel.y() - p[1];
  const double qx = p[3] * x + p[4] * y, qy = p[4] * x + p[5] * y;
  const double g = std::exp(-0.5 * (x * qx + y * qy));
  // A square pixel is, to the fourth order, a Gaussian of its variance; the rest of the fourth order matters
  // for spots of half a pixel.
  const auto fourth = [](double q, double a) { return q * q * (q * q - 6 * a) + 3 * a * a; };
  const double whole = 1 - kPixelFourth * (fourth(qx, p[3]) + fourth(qy, p[5]));
  SpotModel model;
  model.level = p[2] * g * whole;
  model.weight = 1 / (read_variance + shot * std::max(0.0, model.level));
  model.slope << model.level * qx, model.level * qy, g * whole, -0.5 * model.level * x * x,
      -model.level * x * y, -0.5 * model.level * y * y;
  return model;
}

struct SpotSystem {
  SpotNormal normal = SpotNormal::Zero();
  SpotParameters right = SpotParameters::Zero();
  double chi_square = 0;
};

SpotSystem system_of(const SpotPixels& pixels, const SpotParameters& p, double shot) {
  SpotSystem system;
  const double variance = pixels.read * pixels.read;
  for (const Eigen::Vector3d& pixel : pixels.used) {
    const SpotModel model = model_at(p, pixel, variance, shot);
    const double off = pixel.z() - model.level;
    for (int i = 0; i < kNumbers; ++i) {
      const double weighted = model.weight * model.slope[i];
      system.right[i] += weighted * off;
      for (int k = 0; k <= i; ++k) system.normal(i, k) += weighted * model.slope[k];  // the half that is read
    }
    system.chi_square += model.weight * off * off;
  }
  return system;
}

bool is_bounded(const SpotParameters& p) {
  const double determinant = p[3] * p[5] - p[4] * p[4];
  return p.allFinite() && p[2] > 0 && p[3] > 0 && p[5] > 0 && determinant > 0 &&
         std::max(p[3], p[5]) / determinant < kWidestSpot * kWidestSpot;
}

/// Gauss–Newton; a step that leaves the Gaussians or moves too far is shortened.
bool improve(const SpotPixels& pixels, double shot, int steps, SpotParameters& p) {
  for (int k = 0; k < steps; ++k) {
    SpotSystem system = system_of(pixels, p, shot);
    system.normal.diagonal() *= 1 + 1e-9;
    const Eigen::LLT<SpotNormal> factor(system.normal);
    if (factor.info() != Eigen::Success) return false;
    const SpotParameters step = factor.solve(system.right);
    if (!step.allFinite()) return false;
    const double width = 1 / std::sqrt(std::sqrt(std::max(1e-12, p[3] * p[5] - p[4] * p[4])));
    double share = std::min(1.0, width / std::max(1e-12, step.head<2>().norm()));
    const double change = std::max(std::abs(step[3]) / p[3], std::abs(step[5]) / p[5]);
    share = std::min(share, 0.7 / std::max(1e-12, change));
    while (share > 1e-3 && !is_bounded(p + share * step)) share /= 2;
    if (share <= 1e-3) return false;
    p += share * step;
    if (share * step.head<2>().norm() < kSettled && change < 0.02) return true;
  }
  return true;
}

FittedSpot described(const GreyImage& image, const SpotPixels& pixels, double shot, const SpotParameters& p) {
  FittedSpot spot;
  const SpotSystem system = system_of(pixels, p, shot);
  const SpotNormal covariance = system.normal.llt().solve(SpotNormal::Identity());
  const double freedom = std::max(1.0, static_cast<double>(pixels.used.size()) - 6);
  const double factor = std::max(1.0, system.chi_square / freedom);
  spot.centre = p.head<2>();
  spot.covariance = factor * covariance.topLeftCorner<2, 2>();
  spot.peak = p[2];
  spot.peak_sigma = std::sqrt(factor * covariance(2, 2));
  // Variances along the axes: eigenvalues of the inverse of [a b; b c].
  const double determinant = p[3] * p[5] - p[4] * p[4], middle = (p[3] + p[5]) / 2 / determinant;
  const double apart = std::hypot((p[3] - p[5]) / 2, p[4]) / determinant;
  const double longest = std::max(1e-3, middle + apart - kPixelVariance);
  const double shortest = std::max(1e-3, middle - apart - kPixelVariance);
  spot.sigma = std::sqrt(std::sqrt(longest * shortest));
  spot.elongation = std::sqrt(longest / shortest);
  double squares = 0;
  int n = 0;
  for (const Eigen::Vector3d& pixel : pixels.used) {
    if ((pixel.head<2>() - spot.centre).norm() > 2 * spot.sigma + 0.7) continue;
    const double off = pixel.z() - model_at(p, pixel, 1, 0).level;
    squares += off * off;
    ++n;
  }
  spot.misfit = n > 0 ? std::sqrt(squares / n) : 0;
  const double margin = 2 * spot.sigma;
  spot.cut = spot.centre.x() < margin || spot.centre.y() < margin || spot.centre.x() > image.width - margin ||
             spot.centre.y() > image.height - margin;
  return spot;
}

}  // namespace

std::optional<FittedSpot> fit_spot(const GreyImage& image, const SpotGuess& guess, const PixelNoise& noise,
                                   const std::vector<PixelBox>& others) {
  SpotParameters p;
  const double q = 1 / (guess.sigma * guess.sigma + kPixelVariance);
  p << guess.centre, guess.peak, q, 0, q;
  const auto width = [&] { return 1 / std::sqrt(std::sqrt(p[3] * p[5] - p[4] * p[4])); };
  for (const bool last : {false, true}) {
    const Eigen::Vector2d centre = p.head<2>();
    const double half = (last ? kWindow : kFirstWindow) * width();
    if (!(half < kWindow * kWidestSpot) || centre.x() < 0 || centre.y() < 0 || centre.x() >= image.width ||
        centre.y() >= image.height)
      return {};
    const SpotPixels pixels = pixels_of(image, window_of(image, centre, half), centre, noise, others);
    if (pixels.used.size() < kFewestPixels) return {};
    if (!improve(pixels, noise.shot, last ? kLastSteps : kFirstSteps, p)) return {};
    if (last) return described(image, pixels, noise.shot, p);
  }
  return {};
}

}  // namespace batten::detail
