#include "example_models.hpp"

#include <array>
#include <cmath>

#include "batten/core/units.hpp"
#include "batten/sketch/tools.hpp"

namespace batten::experiments {

namespace {

using Eigen::Vector3d;

/// centre + cos t a + sin t b for t from `from` to `to`.
Points arc(const Vector3d& centre, const Vector3d& a, const Vector3d& b, double from, double to,
           int n = 200) {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    const double t = from + (to - from) * i / n;
    points.row(i) = (centre + std::cos(t) * a + std::sin(t) * b).transpose();
  }
  return points;
}

DrawnStroke circle(const Vector3d& centre, const Vector3d& a, const Vector3d& b, int n = 200) {
  return {arc(centre, a, b, 0, 2 * kPi * (n - 1) / n, n - 1), true};
}

DrawnStroke lines(const std::vector<Vector3d>& corners, bool closed = false, int n = 40) {
  const size_t sides = corners.size() - 1;
  Points points(static_cast<Eigen::Index>(sides) * n + 1, 3);
  for (Eigen::Index i = 0; i + 1 < points.rows(); ++i) {
    const auto k = static_cast<size_t>(i / n);
    const double t = static_cast<double>(i % n) / n;
    points.row(i) = ((1 - t) * corners[k] + t * corners[k + 1]).transpose();
  }
  points.row(points.rows() - 1) = corners.back().transpose();
  return {points, closed};
}

/// Draws one stroke after the other.
class Pen {
 public:
  void insert(const DrawnStroke& stroke, const InsertOptions& options = {}) {
    edit([&](PolylineMesh& m) { insert_curve(m, stroke, options); });
  }
  template <typename Tool>
  void edit(Tool&& tool) {
    mesh.begin();
    tool(mesh);
    mesh.commit();
  }
  PolylineMesh mesh;
};

/// The three sections of an ellipsoid by the coordinate planes.
PolylineMesh ellipsoid(const Vector3d& x, const Vector3d& y, const Vector3d& z) {
  Pen pen;
  for (const auto& [a, b] : {std::pair(x, y), std::pair(x, z), std::pair(y, z)})
    pen.insert(circle(Vector3d::Zero(), a, b));
  return pen.mesh;
}

PolylineMesh cylinder(double radius, double height) {
  const Vector3d x = radius * Vector3d::UnitX(), y = radius * Vector3d::UnitY(),
                 z = height * Vector3d::UnitZ();
  Pen pen;
  std::vector<DrawnStroke> profiles;
  for (const double t : {0.0, 0.5, 1.0}) profiles.push_back(circle(t * z, x, y));
  pen.edit([&](PolylineMesh& m) { skin_profiles(m, profiles, {lines({x, x + z}), lines({-x, -x + z})}); });
  for (const double side : {1.0, -1.0}) pen.insert(lines({side * y, side * y + z}));
  return pen.mesh;
}

PolylineMesh torus(double middle, double tube) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = tube * Vector3d::UnitZ();
  const auto around = [&](double radius, double from, double to) {
    return DrawnStroke{arc(Vector3d::Zero(), radius * x, radius * y, from, to), false};
  };
  const double outer = middle + tube, inner = middle - tube, whole = 2 * kPi, end = 1.5 * kPi;
  Pen pen;
  std::vector<DrawnStroke> profiles;
  for (int k = 0; k < 4; ++k) {
    const Vector3d out = std::cos(k * kPi / 2) * x + std::sin(k * kPi / 2) * y;
    profiles.push_back(circle(middle * out, tube * out, z));
  }
  pen.edit([&](PolylineMesh& m) {
    skin_profiles(m, profiles, {around(outer, 0, end), around(inner, 0, end)});
  });
  pen.edit([&](PolylineMesh& m) {
    glue_borders(m, around(outer, end, whole), around(inner, end, whole), std::nullopt);
  });
  for (const double side : {1.0, -1.0}) pen.insert(circle(side * z, middle * x, middle * y));
  return pen.mesh;
}

/// The cube [0, 1]³.
PolylineMesh box() {
  const Vector3d o = Vector3d::Zero(), x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  Pen pen;
  pen.insert(lines({o, x, x + y, y, o}, true), {.sharpness = 1});
  pen.insert(lines({o, z, x + z, x}), {.sharpness = 1, .into = Into::Opening});
  pen.insert(lines({y, y + z, x + y + z, x + y}), {.sharpness = 1});
  pen.insert(lines({z, y + z}), {.sharpness = 1});
  pen.insert(lines({x + z, x + y + z}), {.sharpness = 1});
  return pen.mesh;
}

double distance_from_box(const Vector3d& p) {
  const Eigen::Array3d beyond = (p.array() - 0.5).abs() - 0.5;
  return std::abs(beyond.max(0).matrix().norm() + std::min(0.0, beyond.maxCoeff()));
}

}  // namespace

const std::vector<std::string>& example_model_names() {
  static const std::vector<std::string> names = {"sphere", "ellipsoid", "cylinder", "torus", "box"};
  return names;
}

ExampleModel example_model(const std::string& name) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  if (name == "sphere")
    return {name, ellipsoid(x, y, z), [](const Vector3d& p) { return std::abs(p.norm() - 1); }};
  if (name == "ellipsoid") {
    const Eigen::Array3d axes(1, 0.8, 0.6);
    return {name, ellipsoid(axes[0] * x, axes[1] * y, axes[2] * z), [axes](const Vector3d& p) {
              // |f| / |∇f| of f = Σ (p/a)² − 1.
              const double f = (p.array() / axes).square().sum() - 1;
              return std::abs(f) / (2 * (p.array() / axes.square()).matrix().norm());
            }};
  }
  if (name == "cylinder")
    return {name, cylinder(1, 2), [](const Vector3d& p) { return std::abs(std::hypot(p.x(), p.y()) - 1); }};
  if (name == "torus")
    return {name, torus(2, 0.8), [](const Vector3d& p) {
              return std::abs(std::hypot(std::hypot(p.x(), p.y()) - 2, p.z()) - 0.8);
            }};
  return {name, box(), distance_from_box};
}

}  // namespace batten::experiments
