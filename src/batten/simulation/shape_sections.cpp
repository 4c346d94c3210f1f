#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/simulation/shape_formulas_detail.hpp"
#include "batten/simulation/shape_sections_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

ImplicitFunction plane(const Vector3d& normal, double offset) {
  return [normal, offset](const Vector3d& x, Vector3d& gradient) {
    gradient = normal;
    return normal.dot(x) - offset;
  };
}

ImplicitFunction unit_cylinder() {
  return [](const Vector3d& x, Vector3d& gradient) {
    gradient = {2 * x.x(), 2 * x.y(), 0};
    return x.head<2>().squaredNorm() - 1;
  };
}

const char* axis_name(int axis) {
  return axis == 0 ? "x" : axis == 1 ? "y" : "z";
}

/// The closed section of a star-shaped surface with the plane (axis) = value. `start` need only be near.
ShapeSection closed_section(int axis, double value, Vector3d start) {
  start[axis] = value;
  const Vector3d normal = Vector3d::Unit(axis);
  // Counter-clockwise about the axis.
  return {concat(axis_name(axis), " = ", value), false, plane(normal, value), start, normal.cross(start)};
}

/// The piece of a height field over the line from `a` to `b` in the plane z = 0.
ShapeSection line_section(HeightField height, const std::string& name, bool boundary, Eigen::Vector2d a,
                          Eigen::Vector2d b) {
  const Eigen::Vector2d d = (b - a).normalized();
  const Vector3d normal(-d.y(), d.x(), 0);
  const Vector3d start(a.x(), a.y(), height(a.x(), a.y()).z);
  const Vector3d end(b.x(), b.y(), height(b.x(), b.y()).z);
  return {name, boundary, plane(normal, normal.dot(start)), start, {d.x(), d.y(), 0}, false, end};
}

std::vector<ShapeSection> square_sections(HeightField height, const std::vector<double>& lines) {
  std::vector<ShapeSection> sections = {line_section(height, "border y = -1", true, {-1, -1}, {1, -1}),
                                        line_section(height, "border x = 1", true, {1, -1}, {1, 1}),
                                        line_section(height, "border y = 1", true, {1, 1}, {-1, 1}),
                                        line_section(height, "border x = -1", true, {-1, 1}, {-1, -1})};
  for (const double x : lines)
    sections.push_back(line_section(height, concat("x = ", x), false, {x, -1}, {x, 1}));
  for (const double y : lines)
    sections.push_back(line_section(height, concat("y = ", y), false, {-1, y}, {1, y}));
  return sections;
}

std::vector<ShapeSection> dish_sections() {
  std::vector<ShapeSection> sections;
  sections.push_back({"border", true, unit_cylinder(), {1, 0, dish_height(1, 0).z}, {0, 1, 0}});
  for (const double x : {-0.4, 0.35}) {
    const double y = std::sqrt(1 - x * x);
    sections.push_back(line_section(dish_height, concat("x = ", x), false, {x, -y}, {x, y}));
  }
  for (const double y : {-0.45, 0.1}) {
    const double x = std::sqrt(1 - y * y);
    sections.push_back(line_section(dish_height, concat("y = ", y), false, {-x, y}, {x, y}));
  }
  return sections;
}

std::vector<ShapeSection> star_sections(const std::vector<double>& values, double radius) {
  std::vector<ShapeSection> sections;
  for (int axis = 0; axis < 3; ++axis)
    for (const double value : values) {
      Vector3d start = Vector3d::Zero();
      start[(axis + 1) % 3] = radius;
      sections.push_back(closed_section(axis, value, start));
    }
  return sections;
}

std::vector<ShapeSection> ellipsoid_sections() {
  std::vector<ShapeSection> sections = {closed_section(0, -0.6, {0, 0.9, 0}),
                                        closed_section(0, 0.6, {0, 0.9, 0}),
                                        closed_section(1, 0, {1.5, 0, 0}), closed_section(2, 0, {1.5, 0, 0})};
  sections.push_back({"y + z = 0", false, plane(Vector3d(0, 1, 1).normalized(), 0), {1.5, 0, 0}, {0, 1, -1}});
  return sections;
}

std::vector<ShapeSection> torus_sections() {
  std::vector<ShapeSection> sections;
  for (const double z : {0.0, 1.2, -1.2})
    for (const double side : {1.0, -1.0}) {
      const double radius = kTorusRadius + side * std::sqrt(kTubeRadius * kTubeRadius - z * z);
      ShapeSection circle = closed_section(2, z, {radius, 0, 0});
      circle.name = concat(side > 0 ? "outer" : "inner", " circle z = ", z);
      sections.push_back(circle);
    }
  for (int k = 0; k < 6; ++k) {
    const double phi = k * kPi / 3;
    const Vector3d out(std::cos(phi), std::sin(phi), 0);
    const Vector3d across(-out.y(), out.x(), 0);
    sections.push_back({concat("meridian ", 60 * k, " degrees"),
                        false,
                        plane(across, 0),
                        (kTorusRadius + kTubeRadius) * out,
                        {0, 0, 1}});
  }
  return sections;
}

std::vector<ShapeSection> cone_sections() {
  // The border runs with the surface on its left, seen from outside.
  ShapeSection bottom = closed_section(2, kConeBottom, {cone_radius(kConeBottom), 0, 0});
  ShapeSection top = closed_section(2, kConeTop, {cone_radius(kConeTop), 0, 0});
  bottom.name = "bottom";
  top.name = "top";
  top.towards = -top.towards;
  bottom.boundary = top.boundary = true;
  std::vector<ShapeSection> sections = {bottom, top};
  for (int k = 0; k < 3; ++k) {
    const double phi = 0.2 + k * 2 * kPi / 3;
    const Vector3d out(std::cos(phi), std::sin(phi), 0);
    const Vector3d up(0, 0, 1);
    sections.push_back({concat("generator ", k + 1), false, plane(Vector3d(-out.y(), out.x(), 0), 0),
                        cone_radius(kConeBottom) * out + kConeBottom * up, up, false,
                        cone_radius(kConeTop) * out + kConeTop * up});
  }
  return sections;
}

}  // namespace

std::vector<ShapeSection> sections_of(AnalyticShape shape) {
  switch (shape) {
    case AnalyticShape::Sphere:
      return star_sections({0}, 1);
    case AnalyticShape::Sphere6:
      return star_sections({-0.45, 0.45}, 0.9);
    case AnalyticShape::Ellipsoid:
      return ellipsoid_sections();
    case AnalyticShape::Torus:
      return torus_sections();
    case AnalyticShape::BumpyCube:
      return star_sections({-0.5, 0, 0.5}, 1);
    case AnalyticShape::Saddle:
      return square_sections(saddle_height, {-0.33, 0.33});
    case AnalyticShape::Waves:
      return square_sections(waves_height, {-0.5, 0, 0.5});
    case AnalyticShape::Dish:
      return dish_sections();
    case AnalyticShape::Cone:
      return cone_sections();
  }
  throw InvalidInput("unknown shape");
}

}  // namespace batten::detail
