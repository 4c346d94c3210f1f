#include "batten/mesh/plane_section.hpp"

#include "shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/shape.hpp"

namespace batten {
namespace {

/// A torus around z of radii 2 and 1/2, outward, with as many points around the tube as around the hole.
Shape torus(int n) {
  return fixtures::grid(n, n, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + 0.5 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.5 * std::sin(b));
  });
}

TEST(PlaneSection, OfATorusAreTwoCirclesTheInnerOneAroundItsHole) {
  const Shape shape = torus(200);
  const auto curves = plane_section(shape.positions, shape.triangles, Eigen::Vector3d(0, 0, 3), 0.003);
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_TRUE(curves[0].closed && curves[1].closed);
  // Chords of 200 pieces are 1 − (π/200)²/6 of the circle; the plane is 0.001 above the middle.
  EXPECT_NEAR(curves[0].length / (2 * kPi * 2.5), 1, 1e-4);
  EXPECT_NEAR(curves[1].length / (2 * kPi * 1.5), 1, 1e-4);
  EXPECT_NEAR(curves[0].area / (kPi * 2.5 * 2.5), 1, 4e-4);
  EXPECT_NEAR(curves[1].area / (-kPi * 1.5 * 1.5), 1, 4e-4);
  EXPECT_LT((curves[0].points.col(2).array() - 0.001).abs().maxCoeff(), 1e-12);
}

TEST(PlaneSection, ThroughVerticesGoesThroughEachOfThemOnce) {
  // Rows of vertices lie in the plane y = 0: the tube is cut across in two circles.
  const Shape shape = torus(48);
  const auto curves = plane_section(shape.positions, shape.triangles, Eigen::Vector3d(0, 1, 0), 0);
  ASSERT_EQ(curves.size(), 2U);
  for (const SectionCurve& curve : curves) {
    EXPECT_TRUE(curve.closed);
    EXPECT_NEAR(curve.area / (kPi * 0.25), 1, 3e-3);
    for (Eigen::Index i = 0; i < curve.points.rows(); ++i)
      EXPECT_GT((curve.points.row(i) - curve.points.row((i + 1) % curve.points.rows())).norm(), 0);
  }
  EXPECT_TRUE(plane_section(shape.positions, shape.triangles, Eigen::Vector3d(0, 1, 0), 9).empty());
}

TEST(PlaneSection, OfAnOpenSheetEndsAtItsBorder) {
  const Shape sheet = fixtures::grid(10, 10, false, false,
                                     [](double u, double v) { return Eigen::Vector3d(3 * u, 4 * v, 0); });
  const auto curves = plane_section(sheet.positions, sheet.triangles, Eigen::Vector3d(1, 0, 0), 1.05);
  ASSERT_EQ(curves.size(), 1U);
  EXPECT_FALSE(curves[0].closed);
  EXPECT_NEAR(curves[0].length, 4, 1e-12);
  EXPECT_EQ(curves[0].area, 0);
  EXPECT_NEAR((curves[0].points.row(0) - curves[0].points.bottomRows(1)).norm(), 4, 1e-12);
}

TEST(PlaneSection, RefusesAPlaneThatIsNone) {
  const Shape shape = torus(8);
  EXPECT_THROW(plane_section(shape.positions, shape.triangles, Eigen::Vector3d::Zero(), 0), InvalidInput);
  EXPECT_THROW(plane_section(shape.positions, shape.triangles, Eigen::Vector3d::UnitX(), std::nan("")),
               InvalidInput);
}

}  // namespace
}  // namespace batten
