#include <cmath>

#include <gtest/gtest.h>

#include "batten/simulation/shape_sections_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

/// Distance from the zeros of a function, to first order.
double distance_from(const ImplicitFunction& function, const Vector3d& x) {
  Vector3d gradient;
  const double value = function(x, gradient);
  return std::abs(value) / gradient.norm();
}

// What trace_intersection() asks for: open curves begin and end on the curve, closed ones near it, and all
// leave their start along it.
TEST(ShapeSections, BeginOnTheirCurvesAndLeaveAlongThem) {
  for (const std::string& word : choice_words<AnalyticShape>()) {
    const auto shape = parse_choice<AnalyticShape>(word);
    const ImplicitFunction surface = shape_function(shape);
    for (const ShapeSection& section : sections_of(shape)) {
      EXPECT_LT(distance_from(section.cut, section.start), 1e-12) << word << ' ' << section.name;
      EXPECT_LT(distance_from(surface, section.start), section.closed ? 0.5 : 1e-12)
          << word << ' ' << section.name;
      if (!section.closed) {
        EXPECT_LT(distance_from(section.cut, section.end), 1e-12) << word << ' ' << section.name;
        EXPECT_LT(distance_from(surface, section.end), 1e-12) << word << ' ' << section.name;
        EXPECT_GT(section.towards.dot(section.end - section.start), 0) << word << ' ' << section.name;
      }
      Vector3d normal, across;
      section.cut(section.start, across);
      surface(section.start, normal);
      const Vector3d along = normal.cross(across).normalized();
      EXPECT_GT(std::abs(section.towards.normalized().dot(along)), 0.5) << word << ' ' << section.name;
    }
  }
}

}  // namespace
}  // namespace batten::detail
