#include <cmath>

#include "batten/core/error.hpp"
#include "batten/simulation/shape_formulas_detail.hpp"

namespace batten {

namespace detail {

using Eigen::Vector3d;

double cone_radius(double z) {
  return kConeSlope * (kConeTip - z);
}

ShapeHeight saddle_height(double x, double y) {
  return {0.35 * (x * x - y * y), 0.7 * x, -0.7 * y};
}

ShapeHeight waves_height(double x, double y) {
  return {0.12 * std::sin(3 * x) * std::cos(2.5 * y) + 0.2 * x * x,
          0.36 * std::cos(3 * x) * std::cos(2.5 * y) + 0.4 * x, -0.3 * std::sin(3 * x) * std::sin(2.5 * y)};
}

ShapeHeight dish_height(double x, double y) {
  // cos(3φ) r³ = x³ − 3 x y²
  return {0.18 * (x * x * x - 3 * x * y * y) + 0.12 * (x * x + y * y),
          0.18 * (3 * x * x - 3 * y * y) + 0.24 * x, -1.08 * x * y + 0.24 * y};
}

HeightField height_field(AnalyticShape shape) {
  if (shape == AnalyticShape::Saddle) return saddle_height;
  if (shape == AnalyticShape::Waves) return waves_height;
  return dish_height;
}

double bumpy_cube(const Vector3d& x, Vector3d& gradient) {
  const Vector3d c = (3 * x.array()).cos();
  const Vector3d s = (3 * x.array()).sin();
  gradient = 4 * x.array().cube();
  gradient -= 0.36 * Vector3d(s.x() * c.y() * c.z(), c.x() * s.y() * c.z(), c.x() * c.y() * s.z());
  return x.array().square().square().sum() - 1 + 0.12 * c.prod();
}

Vector3d on_bumpy_cube(const Vector3d& direction) {
  double r = 1.1;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Vector3d gradient;
    const double value = bumpy_cube(r * direction, gradient);
    const double change = value / gradient.dot(direction);
    r -= change;
    if (std::abs(change) < 1e-15) break;
  }
  return r * direction;
}

}  // namespace detail

namespace {

using Eigen::Vector3d;

ImplicitFunction below_height(detail::HeightField height) {
  return [height](const Vector3d& x, Vector3d& gradient) {
    const detail::ShapeHeight h = height(x.x(), x.y());
    gradient = {-h.dx, -h.dy, 1};
    return x.z() - h.z;
  };
}

}  // namespace

ImplicitFunction shape_function(AnalyticShape shape) {
  switch (shape) {
    case AnalyticShape::Sphere:
    case AnalyticShape::Sphere6:
      return [](const Vector3d& x, Vector3d& gradient) {
        gradient = 2 * x;
        return x.squaredNorm() - 1;
      };
    case AnalyticShape::Ellipsoid:
      return [](const Vector3d& x, Vector3d& gradient) {
        const Vector3d scaled = x.cwiseQuotient(detail::kEllipsoidAxes);
        gradient = 2 * scaled.cwiseQuotient(detail::kEllipsoidAxes);
        return scaled.squaredNorm() - 1;
      };
    case AnalyticShape::Torus:
      return [](const Vector3d& x, Vector3d& gradient) {
        const double rho = x.head<2>().norm();
        const double across = rho - detail::kTorusRadius;
        gradient = {2 * across * x.x() / rho, 2 * across * x.y() / rho, 2 * x.z()};
        return across * across + x.z() * x.z() - detail::kTubeRadius * detail::kTubeRadius;
      };
    case AnalyticShape::BumpyCube:
      return detail::bumpy_cube;
    case AnalyticShape::Saddle:
    case AnalyticShape::Waves:
    case AnalyticShape::Dish:
      return below_height(detail::height_field(shape));
    case AnalyticShape::Cone:
      return [](const Vector3d& x, Vector3d& gradient) {
        const double r = detail::cone_radius(x.z());
        gradient = {2 * x.x(), 2 * x.y(), 2 * detail::kConeSlope * r};
        return x.head<2>().squaredNorm() - r * r;
      };
  }
  throw InvalidInput("unknown shape");
}

}  // namespace batten
