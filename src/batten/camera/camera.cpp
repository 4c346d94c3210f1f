#include "batten/camera/camera.hpp"

#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr int kNewtonSteps = 50;
constexpr double kNewtonTolerance = 1e-13;

/// Square of the radius at which the radial part r (1 + k1 r² + k2 r⁴ + k3 r⁶) first stops to grow, the
/// smallest positive root of 1 + 3 k1 s + 5 k2 s² + 7 k3 s³ in s = r²; infinity where it always grows.
double monotone_radius_squared(const Camera& camera) {
  const auto slope = [&](double s) {
    return 1 + s * (3 * camera.k1 + s * (5 * camera.k2 + s * 7 * camera.k3));
  };
  // A cubic falls below zero first at a root or, where it only grows again afterwards, after one of its
  // turning points: between neighbours of this list it is monotone.
  const double a = 21 * camera.k3, b = 10 * camera.k2, c = 3 * camera.k1;
  double turns[2] = {-1, -1};
  if (a != 0) {
    const double discriminant = b * b - 4 * a * c;
    if (discriminant >= 0) {
      const double root = std::sqrt(discriminant);
      turns[0] = std::min((-b - root) / (2 * a), (-b + root) / (2 * a));
      turns[1] = std::max((-b - root) / (2 * a), (-b + root) / (2 * a));
    }
  } else if (b != 0) {
    turns[0] = -c / b;
  }
  double low = 0;
  const auto root_between = [&](double from, double to) {
    for (int step = 0; step < 200 && to - from > 1e-15 * to; ++step) {
      const double middle = (from + to) / 2;
      (slope(middle) > 0 ? from : to) = middle;
    }
    return from;
  };
  for (const double turn : turns) {
    if (turn <= 0) continue;
    if (slope(turn) <= 0) return root_between(low, turn);
    low = turn;
  }
  // Beyond the last turning point: find whether it ever falls below zero.
  double high = low > 0 ? 2 * low : 1;
  for (int doubling = 0; doubling < 60; ++doubling, high *= 2)
    if (slope(high) <= 0) return root_between(low, high);
  return std::numeric_limits<double>::infinity();
}

}  // namespace

std::string problem(const Camera& camera) {
  const auto range = [](const char* field, double value, const char* expected) {
    return concat(field, " is ", value, "; expected ", expected);
  };
  if (camera.width < 1) return range("width", camera.width, "at least 1 pixel");
  if (camera.height < 1) return range("height", camera.height, "at least 1 pixel");
  if (!(camera.fx > 0) || !std::isfinite(camera.fx))
    return range("fx", camera.fx, "a focal length above 0 pixels");
  if (!(camera.fy > 0) || !std::isfinite(camera.fy))
    return range("fy", camera.fy, "a focal length above 0 pixels");
  const struct {
    const char* name;
    double value;
  } numbers[] = {{"cx", camera.cx}, {"cy", camera.cy}, {"k1", camera.k1}, {"k2", camera.k2},
                 {"k3", camera.k3}, {"p1", camera.p1}, {"p2", camera.p2}};
  for (const auto& number : numbers)
    if (!std::isfinite(number.value)) return range(number.name, number.value, "a finite number");
  return {};
}

Eigen::Vector2d distort(const Camera& camera, const Eigen::Vector2d& normalised, Eigen::Matrix2d* jacobian) {
  const double x = normalised.x(), y = normalised.y(), s = normalised.squaredNorm();
  const double radial = 1 + s * (camera.k1 + s * (camera.k2 + s * camera.k3));
  if (jacobian) {
    const double slope = camera.k1 + s * (2 * camera.k2 + s * 3 * camera.k3);  // of `radial` by s
    const double mixed = 2 * x * y * slope + 2 * camera.p1 * x + 2 * camera.p2 * y;
    (*jacobian) << radial + 2 * x * x * slope + 2 * camera.p1 * y + 6 * camera.p2 * x, mixed, mixed,
        radial + 2 * y * y * slope + 6 * camera.p1 * y + 2 * camera.p2 * x;
  }
  return {x * radial + 2 * camera.p1 * x * y + camera.p2 * (s + 2 * x * x),
          y * radial + camera.p1 * (s + 2 * y * y) + 2 * camera.p2 * x * y};
}

Eigen::Vector2d to_pixel(const Camera& camera, const Eigen::Vector2d& distorted) {
  return {camera.fx * distorted.x() + camera.cx, camera.fy * distorted.y() + camera.cy};
}

Eigen::Vector2d from_pixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  return {(pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy};
}

Eigen::Vector2d project(const Camera& camera, const Eigen::Vector3d& point,
                        Eigen::Matrix<double, 2, 3>* jacobian) {
  const double inverse = 1 / point.z();
  const Eigen::Vector2d normalised = point.head<2>() * inverse;
  Eigen::Matrix2d of_distortion;
  const Eigen::Vector2d pixel =
      to_pixel(camera, distort(camera, normalised, jacobian ? &of_distortion : nullptr));
  if (jacobian) {
    Eigen::Matrix<double, 2, 3> of_division;
    of_division << inverse, 0, -normalised.x() * inverse, 0, inverse, -normalised.y() * inverse;
    *jacobian = Eigen::Vector2d(camera.fx, camera.fy).asDiagonal() * of_distortion * of_division;
  }
  return pixel;
}

std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d wanted = from_pixel(camera, pixel);
  const double limit = monotone_radius_squared(camera);
  Eigen::Vector2d point = wanted;
  if (point.squaredNorm() > limit) point *= 0.9 * std::sqrt(limit) / point.norm();
  for (int step = 0; step < kNewtonSteps; ++step) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d residual = distort(camera, point, &jacobian) - wanted;
    if (residual.norm() <= kNewtonTolerance * (1 + wanted.norm())) return point;
    Eigen::Vector2d change = jacobian.inverse() * residual;
    if (!change.allFinite()) return {};
    // Halved while a step does not help or leaves the part of the model that is one-to-one.
    double share = 1;
    Eigen::Vector2d next = point - change;
    while (share > 1e-6 &&
           (next.squaredNorm() > limit || (distort(camera, next) - wanted).norm() >= residual.norm())) {
      share /= 2;
      next = point - share * change;
    }
    if (share <= 1e-6) return residual.norm() <= 1e-10 ? std::optional(point) : std::nullopt;
    point = next;
  }
  return {};
}

}  // namespace batten
