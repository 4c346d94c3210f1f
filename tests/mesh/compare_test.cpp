#include "batten/mesh/compare.hpp"

#include "mesh/shapes.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

// Spheres of radius 1 and 1.1: the distance is 0.1 up to the sagitta of the facets, r (1 − cos(edge / √3 r)).
TEST(Compare, MeasuresTheGapOfConcentricSpheres) {
  const double sagitta = 1.1 * (1 - std::cos(1.6 / 60));
  const Comparison found = compare(fixtures::sphere(60), fixtures::sphere(60, 1.1), {.samples = 20000});
  for (const DirectedComparison& side : {found.a_to_b, found.b_to_a})
    for (const DistanceFigures& figures : {side.vertices, side.samples}) {
      EXPECT_NEAR(figures.max, 0.1, sagitta);
      EXPECT_NEAR(figures.mean, 0.1, sagitta);
      EXPECT_NEAR(figures.rms, 0.1, sagitta);
      EXPECT_LE(figures.mean, figures.rms * (1 + 1e-12));
      EXPECT_LE(figures.rms, figures.max * (1 + 1e-12));
    }
  EXPECT_NEAR(found.diameter, 2.2 * std::sqrt(3.0), 1e-12);
  EXPECT_EQ(found.a_to_b.samples.count, 20000);
}

// Parallel squares, the second half as wide: from the small one every distance is 1; from the large one the
// mean square over (x, y) ∈ [0, 2]² is 1 + ∫ max(x − 1, 0)² dx dy / 4 = 1 + 1/6, the maximum √2.
TEST(Compare, MeasuresBothDirections) {
  const Shape wide =
      fixtures::grid(8, 8, false, false, [](double u, double v) { return Eigen::Vector3d(2 * u, 2 * v, 0); });
  const Shape narrow =
      fixtures::grid(8, 8, false, false, [](double u, double v) { return Eigen::Vector3d(u, 2 * v, 1); });
  const Comparison found = compare(wide, narrow, {.samples = 50000});
  EXPECT_NEAR(found.b_to_a.samples.max, 1, 1e-14);
  EXPECT_NEAR(found.b_to_a.samples.mean, 1, 1e-14);
  EXPECT_EQ(found.a_to_b.vertices.max, std::sqrt(2.0));
  EXPECT_NEAR(found.a_to_b.samples.rms, std::sqrt(1 + 1.0 / 6), 2e-3);
  EXPECT_EQ(found.a_to_b.vertex_distances.size(), wide.positions.rows());
}

// A square and the same turned about one of its sides by 30°: every pair of normals is 30° apart. Turned
// inside out, 150°. Curves have no normals.
TEST(Compare, MeasuresTheAngleBetweenNormals) {
  const auto tilted = [](double angle) {
    return fixtures::grid(6, 6, false, false, [=](double u, double v) {
      return Eigen::Vector3d(u * std::cos(angle), v, u * std::sin(angle));
    });
  };
  const Shape flat = tilted(0);
  Shape turned = tilted(kPi / 6);
  const CompareOptions few{.samples = 1000};
  for (const DirectedComparison& side :
       {compare(flat, turned, few).a_to_b, compare(flat, turned, few).b_to_a}) {
    EXPECT_EQ(side.normal_angles.count, 1000);
    EXPECT_NEAR(side.normal_angles.max, kPi / 6, 1e-12);
    EXPECT_NEAR(side.normal_angles.mean, kPi / 6, 1e-12);
    EXPECT_NEAR(side.normal_angles.rms, kPi / 6, 1e-12);
  }
  turned.triangles.col(0).swap(turned.triangles.col(1));
  EXPECT_NEAR(compare(flat, turned, few).a_to_b.normal_angles.mean, 5 * kPi / 6, 1e-12);
  EXPECT_EQ(compare(flat, fixtures::knot(100), few).a_to_b.normal_angles.count, 0);
}

// The second shape is a square turned over and, beside it, a triangle without area, to which the points
// beyond are nearest: they have no normal to be held against, and all that have one see half a turn.
TEST(Compare, LeavesNormalsOutWhereTheNearestFaceHasNoArea) {
  const Shape wide =
      fixtures::grid(4, 4, false, false, [](double u, double v) { return Eigen::Vector3d(2 * u, v, 0); });
  Shape other;
  other.positions =
      (Points(7, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0, 2, 0.5, 0).finished();
  other.triangles = (Triangles(3, 3) << 0, 2, 1, 0, 3, 2, 4, 5, 6).finished();
  const DirectedComparison found = compare(wide, other, {.samples = 4000}).a_to_b;
  EXPECT_NEAR(static_cast<double>(found.normal_angles.count), 3000, 150);  // x < 1.5 of 2
  EXPECT_NEAR(found.normal_angles.mean, kPi, 1e-12);
}

// A piece of slope 1 over a quarter of the width: its normals are 45° from the plane's. By area, seen from
// it, √2/4 of √2/4 + 3/4.
TEST(Compare, WeighsNormalsByArea) {
  const Shape flat =
      fixtures::grid(4, 4, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  const Shape ramp = fixtures::grid(
      4, 4, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, std::max(u - 0.75, 0.0)); });
  const double share = std::sqrt(2.0) / 4 / (std::sqrt(2.0) / 4 + 0.75);
  EXPECT_NEAR(compare(ramp, flat, {.samples = 50000}).a_to_b.normal_angles.mean, share * kPi / 4, 0.005);
}

// Swapping the shapes swaps the vertex figures exactly; samples are other random points.
TEST(Compare, IsSymmetricInItsArguments) {
  const Shape a = fixtures::blob(12), b = fixtures::knot(100);
  const Comparison ab = compare(a, b, {.samples = 20000}), ba = compare(b, a, {.samples = 20000});
  EXPECT_EQ(ab.a_to_b.vertices.mean, ba.b_to_a.vertices.mean);
  EXPECT_EQ(ab.b_to_a.vertices.rms, ba.a_to_b.vertices.rms);
  EXPECT_NEAR(ab.a_to_b.samples.mean, ba.b_to_a.samples.mean, 0.01);
}

TEST(Compare, RegistrationTakesAMotionAndAScaleAway) {
  const Shape b = fixtures::blob(8);
  Shape a = b;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 1).normalized()).toRotationMatrix();
  a.positions = ((1.2 * b.positions) * R.transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
  EXPECT_GT(compare(a, b, {.samples = 1000}).a_to_b.vertices.mean, 1);
  EXPECT_GT(
      compare(a, b, {.registration = RegistrationKind::Rigid, .samples = 1000, .registration_samples = 1000})
          .a_to_b.vertices.mean,
      0.1);
  const Comparison found = compare(
      a, b, {.registration = RegistrationKind::Similarity, .samples = 1000, .registration_samples = 1000});
  EXPECT_LT(found.a_to_b.vertices.max, 1e-9);
  EXPECT_NEAR(found.registration.transform.scale, 1.0 / 1.2, 1e-9);
}

TEST(Compare, LeavesOutVerticesWithoutElements) {
  Shape a = fixtures::sphere(4);
  const Shape b = a;
  a.positions.conservativeResize(a.positions.rows() + 1, 3);
  a.positions.bottomRows(1).setConstant(1000);
  const Comparison found = compare(a, b, {.samples = 100});
  EXPECT_LT(found.a_to_b.vertices.max, 1e-14);
  EXPECT_TRUE(std::isnan(found.a_to_b.vertex_distances[a.positions.rows() - 1]));
}

TEST(Compare, RefusesEmptyShapes) {
  EXPECT_THROW(compare(Shape{}, fixtures::knot(10)), InvalidInput);
  EXPECT_THROW(compare(fixtures::knot(10), Shape{}), InvalidInput);
  EXPECT_THROW(compare(fixtures::knot(10), fixtures::knot(10), {.samples = 0}), InvalidInput);
}

TEST(DistanceFigures, OfKnownNumbers) {
  const DistanceFigures figures = distance_figures(Eigen::Vector3d(0, 3, 6));
  EXPECT_EQ(figures.max, 6);
  EXPECT_EQ(figures.mean, 3);
  EXPECT_DOUBLE_EQ(figures.rms, std::sqrt(15.0));
  EXPECT_EQ(distance_figures(Eigen::VectorXd(0)).count, 0);
}

}  // namespace
}  // namespace batten
