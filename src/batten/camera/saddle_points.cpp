#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "batten/camera/saddle_points_detail.hpp"
#include "batten/core/units.hpp"

namespace batten::detail {

namespace {

std::vector<float> gaussian_weights(double sigma) {
  const int reach = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<float> weights;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
  for (int i = -reach; i <= reach; ++i)
    weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)) / sum));
  return weights;
}

/// Second derivatives at a pixel, by central differences.
struct Curvature {
  double xx, xy, yy;
};
Curvature curvature_at(const SmoothImage& image, int x, int y) {
  const double middle = image.at(x, y);
  return {
      image.at(x + 1, y) - 2 * middle + image.at(x - 1, y),
      (image.at(x + 1, y + 1) - image.at(x - 1, y + 1) - image.at(x + 1, y - 1) + image.at(x - 1, y - 1)) /
          4.0,
      image.at(x, y + 1) - 2 * middle + image.at(x, y - 1)};
}

/// Of a saddle with second derivatives of this determinant: see SaddlePoint::contrast.
double contrast_of(double determinant, double sigma) {
  return determinant < 0 ? std::sqrt(-determinant) * sigma * sigma * kPi / 2 : 0;
}

}  // namespace

SmoothImage::SmoothImage(const GreyImage& image, double sigma)
    : width_(image.width), height_(image.height), sigma_(sigma) {
  const std::vector<float> weights = gaussian_weights(sigma);
  const int reach = static_cast<int>(weights.size()) / 2;
  const auto place = [this](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  };
  std::vector<float> rows(image.pixels.size());
  values_.resize(image.pixels.size());
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      float sum = 0;
      for (int i = -reach; i <= reach; ++i)
        sum += weights[static_cast<std::size_t>(i + reach)] * image.at(std::clamp(x + i, 0, width_ - 1), y);
      rows[place(x, y)] = sum;
    }
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      float sum = 0;
      for (int i = -reach; i <= reach; ++i)
        sum +=
            weights[static_cast<std::size_t>(i + reach)] * rows[place(x, std::clamp(y + i, 0, height_ - 1))];
      values_[place(x, y)] = sum;
    }
}

double SmoothImage::sample(const Eigen::Vector2d& place) const {
  const double x = std::clamp(place.x() - 0.5, 0.0, width_ - 1.0);
  const double y = std::clamp(place.y() - 0.5, 0.0, height_ - 1.0);
  const int i = std::min(static_cast<int>(x), std::max(0, width_ - 2));
  const int j = std::min(static_cast<int>(y), std::max(0, height_ - 2));
  const int right = std::min(i + 1, width_ - 1), below = std::min(j + 1, height_ - 1);
  const double s = x - i, t = y - j;
  return (1 - t) * ((1 - s) * at(i, j) + s * at(right, j)) +
         t * ((1 - s) * at(i, below) + s * at(right, below));
}

std::optional<SaddlePoint> saddle_near(const SmoothImage& image, const Eigen::Vector2d& start,
                                       double radius) {
  constexpr int kMostSteps = 20;
  const int reach = static_cast<int>(std::ceil(radius));
  // Normal equations of a + b x + c y + d x² + e x y + f y²: the same for every place.
  std::vector<Eigen::Vector2d> offsets;
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  const auto monomials = [](const Eigen::Vector2d& o) {
    Eigen::Matrix<double, 6, 1> row;
    row << 1, o.x(), o.y(), o.x() * o.x(), o.x() * o.y(), o.y() * o.y();
    return row;
  };
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i) {
      if (i * i + j * j > radius * radius) continue;
      offsets.emplace_back(i, j);
      A += monomials(offsets.back()) * monomials(offsets.back()).transpose();
    }
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factor(A);
  Eigen::Vector2d place = start;
  for (int step = 0; step < kMostSteps; ++step) {
    if (place.x() < radius || place.y() < radius || place.x() > image.width() - radius ||
        place.y() > image.height() - radius)
      return {};
    Eigen::Matrix<double, 6, 1> rhs = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Eigen::Vector2d& offset : offsets) rhs += monomials(offset) * image.sample(place + offset);
    const Eigen::Matrix<double, 6, 1> q = factor.solve(rhs);
    Eigen::Matrix2d H;
    H << 2 * q[3], q[4], q[4], 2 * q[5];
    if (!(H.determinant() < 0)) return {};
    const Eigen::Vector2d shift = -(H.inverse() * q.segment<2>(1));
    if (!shift.allFinite()) return {};
    // Far from its centre the window says little: half a window at a time.
    place += shift.norm() > radius / 2 ? Eigen::Vector2d(shift * (radius / 2 / shift.norm())) : shift;
    if ((place - start).norm() > 1.5 * radius) return {};
    if (shift.norm() < 1e-4) return SaddlePoint{place, contrast_of(H.determinant(), image.sigma())};
  }
  return {};
}

std::vector<SaddlePoint> saddle_points(const SmoothImage& image, double contrast) {
  const int reach = std::max(2, static_cast<int>(std::lround(2 * image.sigma())));
  const int w = image.width(), h = image.height();
  if (w <= 2 * reach + 2 || h <= 2 * reach + 2) return {};
  std::vector<float> response(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0.0F);
  const auto at = [&](int x, int y) -> float& {
    return response[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)];
  };
  for (int y = 1; y + 1 < h; ++y)
    for (int x = 1; x + 1 < w; ++x) {
      const Curvature c = curvature_at(image, x, y);
      at(x, y) = static_cast<float>(contrast_of(c.xx * c.yy - c.xy * c.xy, image.sigma()));
    }
  std::vector<SaddlePoint> points;
  for (int y = reach; y + reach < h; ++y)
    for (int x = reach; x + reach < w; ++x) {
      const float value = at(x, y);
      if (value < contrast) continue;
      bool is_largest = true;
      for (int j = -reach; j <= reach && is_largest; ++j)
        for (int i = -reach; i <= reach && is_largest; ++i)
          // Of two equal ones the first counts.
          is_largest =
              at(x + i, y + j) < value || (at(x + i, y + j) == value && (j > 0 || (j == 0 && i >= 0)));
      if (!is_largest) continue;
      const auto point = saddle_near(image, Eigen::Vector2d(x + 0.5, y + 0.5), 2 * image.sigma());
      if (point) points.push_back({point->place, value});
    }
  std::stable_sort(points.begin(), points.end(),
                   [](const SaddlePoint& a, const SaddlePoint& b) { return a.contrast > b.contrast; });
  return points;
}

}  // namespace batten::detail
