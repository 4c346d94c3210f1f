#include "batten/pipeline/shape_comparison.hpp"

#include "mesh/shapes.hpp"
#include "network/sample_networks.hpp"
#include "sanitizers.hpp"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

TriangleMesh torus(double thickness) {
  return fixtures::as_mesh(fixtures::grid(40, 20, true, true, [=](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + thickness * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), thickness * std::sin(b));
  }));
}

TEST(ShapeOf, ANetworkHasASegmentForEveryStepOfItsCurves) {
  const CurveNetwork network = samples::octahedral_sphere(4);
  const Shape shape = shape_of(network);
  EXPECT_FALSE(shape.is_surface());
  EXPECT_EQ(shape.segments.rows(), 12 * 4);  // twelve arcs of four steps
  EXPECT_EQ(shape.positions, network.positions);
}

// Tubes of radius 0.5 and 0.6 about one circle: the same vertices moved by 0.1 along their normals.
TEST(ComparedShapes, IsTheComparisonOfTheRoomBelowWithItsSummary) {
  const TriangleMesh a = torus(0.5), b = torus(0.6);
  CompareOptions options;
  options.samples = 2000;
  const ShapeComparison found = compared_shapes(shape_of(a), shape_of(b), options);
  EXPECT_EQ(found.distances.a_to_b.vertex_distances,
            compare(shape_of(a), shape_of(b), options).a_to_b.vertex_distances);
  EXPECT_NEAR(found.hausdorff, 0.1, 0.01);
  ASSERT_TRUE(found.variation.has_value());
  EXPECT_EQ(found.variation->mean_curvature,
            mesh_variation(b.positions, b.triangles, a.positions, a.triangles).mean_curvature);
  EXPECT_TRUE(found.warnings.empty());
}

TEST(ComparedShapes, CurvesAndBrokenSurfacesHaveNoVariation) {
  CompareOptions options;
  options.samples = 200;
  const Shape network = shape_of(samples::octahedral_sphere(4));
  EXPECT_FALSE(compared_shapes(network, fixtures::sphere(6), options).variation.has_value());
  TriangleMesh turned = torus(0.5);
  std::swap(turned.triangles(0, 1), turned.triangles(0, 2));
  EXPECT_FALSE(compared_shapes(shape_of(turned), shape_of(torus(0.5)), options).variation.has_value());
  EXPECT_FALSE(compared_shapes(shape_of(torus(0.5)), shape_of(turned), options).variation.has_value());
}

TEST(MeasuredMesh, IsMovedWithItsNormalsAndHasItsDistances) {
  TriangleMesh a = torus(0.5);
  a.normals = Points::Zero(a.n_vertices(), 3);
  a.normals.col(0).setOnes();
  Comparison distances;
  distances.registration.transform.scale = 2;
  distances.registration.transform.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // a quarter turn about z
  distances.registration.transform.translation << 0, 0, 5;
  distances.a_to_b.vertex_distances = Eigen::VectorXd::LinSpaced(a.n_vertices(), 0, 1);
  const TriangleMesh moved = measured_mesh(a, distances);
  const Eigen::RowVector3d p = a.positions.row(7);
  EXPECT_LT((moved.positions.row(7) - Eigen::RowVector3d(-2 * p[1], 2 * p[0], 2 * p[2] + 5)).norm(), 1e-12);
  EXPECT_LT((moved.normals.row(7) - Eigen::RowVector3d(0, 1, 0)).norm(), 1e-15);
  EXPECT_EQ(moved.vertex_values.at("distance"), distances.a_to_b.vertex_distances);
}

// The truth itself, turned a quarter and moved, has no errors. One larger by a twentieth in every direction
// is off by that of its longest half axis, 1, at the tips of it: no rigid motion mends that.
TEST(TruthErrors, AreInPerCentOfTheTruthAfterARigidMotion) {
  Shape truth = fixtures::sphere(5);
  truth.positions = truth.positions * Eigen::Vector3d(1, 0.8, 0.6).asDiagonal();
  Shape made = truth;
  for (Eigen::Index v = 0; v < made.positions.rows(); ++v) {
    const Eigen::RowVector3d p = truth.positions.row(v);
    made.positions.row(v) << -p[1] + 3, p[0], p[2] - 1;
  }
  const TruthErrors none = truth_errors(made, truth);
  EXPECT_LT(none.figures.max, 1e-5);
  EXPECT_NEAR(none.diameter, 2 * std::sqrt(2.0), 1e-12);  // of the box 2 × 1.6 × 1.2
  made.positions = 1.05 * truth.positions;
  const TruthErrors some = truth_errors(made, truth);
  EXPECT_NEAR(some.figures.max, 5 / none.diameter, 0.05);  // it is fitted at random points
  EXPECT_EQ(some.vertices.maxCoeff(), some.figures.max);
  EXPECT_LT(some.normal_angles.mean, radians(10.0));
  EXPECT_NEAR(some.lengths.max, some.figures.max / 100 * some.diameter, 1e-15);
  EXPECT_NEAR(some.lengths.rms, some.figures.rms / 100 * some.diameter, 1e-15);
}

TEST(TruthErrors, MovesByTheMotionsThatAreAllowed) {
  if (test::kSanitized) GTEST_SKIP() << "a sphere fits in every pose: minutes under the sanitizers";
  const Shape truth = fixtures::sphere(4);
  Shape made = truth;
  made.positions.col(0).array() += 0.25;
  EXPECT_NEAR(truth_errors(made, truth, RegistrationKind::None).lengths.max, 0.25, 0.02);
  made.positions = (2 * made.positions).eval();
  EXPECT_GT(truth_errors(made, truth).lengths.max, 0.9);  // a sphere of twice the radius
  EXPECT_LT(truth_errors(made, truth, RegistrationKind::Similarity).lengths.max, 1e-5);
}

TEST(ComparedShapes, RefusesAndCancels) {
  const Shape torus_shape = shape_of(torus(0.5));
  EXPECT_THROW(compared_shapes({}, torus_shape), InvalidInput);
  CompareOptions options;
  options.samples = 0;
  EXPECT_THROW(compared_shapes(torus_shape, torus_shape, options), InvalidInput);
  EXPECT_THROW(
      compared_shapes(torus_shape, torus_shape, {}, Progress([](std::string_view, double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace batten
