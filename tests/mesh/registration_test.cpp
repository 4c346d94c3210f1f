#include "batten/mesh/registration.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

SimilarityTransform turned(double degrees_of_turn, const Vector3d& axis, double scale, const Vector3d& move) {
  return {scale, Eigen::AngleAxisd(radians(degrees_of_turn), axis.normalized()).toRotationMatrix(), move};
}

Shape moved(Shape shape, const SimilarityTransform& transform) {
  shape.positions = transform(shape.positions);
  return shape;
}

/// Largest distance between where two transforms take the vertices of a shape.
double disagreement(const Shape& shape, const SimilarityTransform& a, const SimilarityTransform& b) {
  return (a(shape.positions) - b(shape.positions)).rowwise().norm().maxCoeff();
}

TEST(FitTransform, RecoversAnExactSimilarity) {
  Random random(4);
  Points from(20, 3);
  for (int i = 0; i < 20; ++i) from.row(i) = random.normal3();
  for (const double scale : {1e-3, 1.0, 1e3}) {
    const SimilarityTransform truth = turned(163, {1, 2, -1}, scale, {3, -4, 5});
    const SimilarityTransform found = fit_transform(from, truth(from), RegistrationKind::Similarity);
    EXPECT_NEAR(found.scale / scale, 1, 1e-13);
    EXPECT_LT((found.rotation - truth.rotation).norm(), 1e-13);
    EXPECT_LT((found.translation - truth.translation).norm(), 1e-12 * (1 + scale));
    EXPECT_LT((found.inverse()(truth(from)) - from).norm(), 1e-13 * (10 + 10 / scale));
    EXPECT_LT(((found * truth.inverse())(truth(from)) - truth(from)).norm(), 1e-12 * (1 + scale));
  }
}

// A mirrored copy of points in general position: the best rotation is a proper one, and no small turn of it
// is better (first-order optimality checked by turning about each axis).
TEST(FitTransform, NeverReflects) {
  Random random(9);
  Points from(30, 3);
  for (int i = 0; i < 30; ++i) from.row(i) = random.normal3();
  Points to = from;
  to.col(0) *= -1;
  const SimilarityTransform found = fit_transform(from, to, RegistrationKind::Rigid);
  EXPECT_NEAR(found.rotation.determinant(), 1, 1e-12);
  const double best = (found(from) - to).squaredNorm();
  for (int axis = 0; axis < 3; ++axis)
    for (const double turn : {-1e-3, 1e-3}) {
      SimilarityTransform other = found;
      other.rotation = Eigen::AngleAxisd(turn, Vector3d::Unit(axis)).toRotationMatrix() * found.rotation;
      const Vector3d from_mean = from.colwise().mean(), to_mean = to.colwise().mean();
      other.translation = to_mean - other.rotation * from_mean;
      EXPECT_GT((other(from) - to).squaredNorm(), best);
    }
}

// The scale, too, is the best for that rotation: where one axis is mirrored, smaller than the ratio of the
// sizes. The error is a parabola in the scale with its vertex there.
TEST(FitTransform, FindsTheBestScaleOfAMirroredCopy) {
  Random random(9);
  Points from(30, 3);
  for (int i = 0; i < 30; ++i) from.row(i) = random.normal3();
  Points to = 2 * from;
  to.col(0) *= -1;
  SimilarityTransform found = fit_transform(from, to, RegistrationKind::Similarity);
  const auto error = [&](double scale) {
    SimilarityTransform other = found;
    other.scale = scale;
    // The translation that goes with it keeps the centroids together.
    const Eigen::RowVector3d a = from.colwise().mean(), b = to.colwise().mean();
    other.translation = b.transpose() - scale * (found.rotation * a.transpose());
    return (other(from) - to).squaredNorm();
  };
  const double best = error(found.scale);
  EXPECT_LT(best, error(1.001 * found.scale));
  EXPECT_LT(best, error(0.999 * found.scale));
}

TEST(FitTransform, WeightsOfZeroLeavePairsOut) {
  Random random(2);
  Points from(10, 3);
  for (int i = 0; i < 10; ++i) from.row(i) = random.normal3();
  const SimilarityTransform truth = turned(40, {0, 1, 1}, 1, {1, 0, 0});
  Points to = truth(from);
  to.row(7).setConstant(50);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(10);
  weights[7] = 0;
  const SimilarityTransform found = fit_transform(from, to, RegistrationKind::Rigid, weights);
  EXPECT_LT((found.rotation - truth.rotation).norm(), 1e-13);
}

TEST(FitTransform, RefusesDegeneratePairs) {
  Points line(5, 3);
  for (int i = 0; i < 5; ++i) line.row(i) << i, 2 * i, -i;
  EXPECT_THROW(fit_transform(line, line, RegistrationKind::Rigid), InvalidInput);
  EXPECT_THROW(fit_transform(line.topRows(2), line.topRows(2), RegistrationKind::Rigid), InvalidInput);
  EXPECT_THROW(fit_transform(line, line.topRows(4), RegistrationKind::Rigid), InvalidInput);
  EXPECT_THROW(fit_transform(line * NAN, line, RegistrationKind::Rigid), InvalidInput);
}

// The shape itself, moved: the answer is the inverse of the motion, to the tolerance of the iteration.
TEST(RegisterShapes, UndoesAnyMotionOfASurface) {
  const Shape fixed = fixtures::blob(10);
  for (const double turn : {35.0, 178.0}) {
    const SimilarityTransform motion = turned(turn, {1, 0.4, -0.3}, 1, {0.3, 5, -2});
    const Registration found = register_shapes(moved(fixed, motion), fixed, {.samples = 500});
    EXPECT_TRUE(found.converged);
    EXPECT_LT(disagreement(fixed, found.transform * motion, {}), 1e-9) << turn;
    EXPECT_LT(found.rms, 1e-10);
  }
}

TEST(RegisterShapes, UndoesAMotionWithScaleOfSurfacesAndOfCurves) {
  for (const double scale : {1e-3, 1e3}) {
    const SimilarityTransform motion = turned(25, {0.2, 1, 0.5}, scale, {1, 2, 3});
    const RegistrationOptions options{.kind = RegistrationKind::Similarity, .samples = 500};
    for (const Shape& fixed : {fixtures::blob(10), fixtures::knot(300)}) {
      const Registration found = register_shapes(moved(fixed, motion), fixed, options);
      EXPECT_LT(disagreement(fixed, found.transform * motion, {}), 1e-8) << scale;
      EXPECT_NEAR(found.transform.scale * scale, 1, 1e-8);
    }
  }
}

// Curves drawn on a surface, both ways round.
TEST(RegisterShapes, MovesCurvesOntoTheirSurfaceAndBack) {
  const Shape surface = fixtures::blob(10);
  Shape curves = surface;  // some of its edges
  curves.triangles.resize(0, 3);
  std::vector<std::pair<int, int>> edges;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); t += 3)
    edges.emplace_back(surface.triangles(t, 0), surface.triangles(t, 1));
  curves.segments.resize(static_cast<Eigen::Index>(edges.size()), 2);
  for (std::size_t e = 0; e < edges.size(); ++e)
    curves.segments.row(static_cast<Eigen::Index>(e)) << edges[e].first, edges[e].second;
  const SimilarityTransform motion = turned(15, {1, 1, 0}, 1, {0.2, 0.1, 0});
  const RegistrationOptions options{.samples = 500};
  EXPECT_LT(
      disagreement(curves, register_shapes(moved(curves, motion), surface, options).transform * motion, {}),
      1e-8);
  EXPECT_LT(
      disagreement(surface, register_shapes(moved(surface, motion), curves, options).transform * motion, {}),
      1e-8);
}

// The misfit is told in the unit of the fixed shape, also where the curves, though fixed, are the ones that
// are matched: the unit of the moving surface is no matter.
TEST(RegisterShapes, TellsTheMisfitInTheUnitOfTheFixedShape) {
  Shape surface = fixtures::blob(10), curves = fixtures::knot(200);
  const RegistrationOptions options{.kind = RegistrationKind::Similarity, .samples = 500};
  const Registration expected = register_shapes(surface, curves, options);
  EXPECT_GT(expected.rms, 1e-3);
  surface.positions *= 1024;
  const Registration found = register_shapes(surface, curves, options);
  EXPECT_NEAR(found.transform.scale * 1024 / expected.transform.scale, 1, 1e-6);
  EXPECT_NEAR(found.rms / expected.rms, 1, 1e-6);
}

// An ellipsoid of three different axes falls onto itself after half a turn about each; of the four ways the
// one nearest to how it lies is taken.
TEST(RegisterShapes, OfSymmetricShapesTakesTheLeastTurn) {
  Shape fixed = fixtures::sphere(16);
  fixed.positions *= Vector3d(3, 2, 1).asDiagonal();
  for (const Vector3d& axis : {Vector3d(1, 0.2, 0), Vector3d(0, 1, 0.3), Vector3d(0.2, 0, 1)}) {
    const SimilarityTransform motion = turned(12, axis, 1, {0.2, -0.1, 0.1});
    const Registration found = register_shapes(moved(fixed, motion), fixed, {.samples = 1000});
    EXPECT_NEAR(degrees(found.transform.angle()), 12, 0.01);
  }
}

// An arc slid along its own circle: only its ends tell, and they are enough.
TEST(RegisterShapes, EndsHoldACurveThatSlidesAlongItself) {
  Shape fixed;
  fixed.positions.resize(101, 3);
  fixed.segments.resize(100, 2);
  for (int i = 0; i <= 100; ++i) {
    fixed.positions.row(i) << std::cos(0.015 * i), std::sin(0.015 * i), 0;
    if (i < 100) fixed.segments.row(i) << i, i + 1;
  }
  const SimilarityTransform motion = turned(9, {0, 0, 1}, 1, {0, 0, 0});  // about the middle of the circle
  const Registration found = register_shapes(moved(fixed, motion), fixed, {.samples = 2000});
  EXPECT_LT(disagreement(fixed, found.transform * motion, {}), 2e-3);
  EXPECT_LT(found.rms, 1e-3);
}

// Every rotation of a sphere is as good: it must stay as it lies, and only the offset be found.
TEST(RegisterShapes, LeavesASphereAsItLies) {
  const Shape sphere = fixtures::sphere(20);
  const Registration found =
      register_shapes(fixtures::sphere(20, 1, {0.1, 0.2, -0.3}), sphere, {.samples = 2000});
  EXPECT_LT(found.transform.angle(), 1e-3);
  EXPECT_LT((found.transform.translation + Vector3d(0.1, 0.2, -0.3)).norm(), 2e-3);
}

// A tenth of the surface pulled away: trimmed, the rest falls in place (but for the walls
// of the bump); untrimmed it cannot.
TEST(RegisterShapes, TrimmingIgnoresAPartThatDoesNotFit) {
  const Shape fixed = fixtures::blob(16);
  const SimilarityTransform motion = turned(5, {0, 0, 1}, 1, {0.05, 0, 0});
  Shape bent = fixed;
  for (Eigen::Index i = 0; i < bent.positions.rows(); ++i)
    if (bent.positions(i, 2) > 0.8) bent.positions(i, 2) += 0.5;
  const Shape moving = moved(bent, motion);
  const auto error = [&](double trim) {
    return disagreement(
        fixed, register_shapes(moving, fixed, {.samples = 1000, .trim = trim}).transform * motion, {});
  };
  EXPECT_LT(error(0.3), 1e-3);
  EXPECT_GT(error(0), 1e-2);
}

TEST(RegisterShapes, RefusesLinesAndBadOptions) {
  Shape line;
  line.positions.resize(3, 3);
  line.positions << 0, 0, 0, 1, 1, 1, 3, 3, 3;
  line.segments.resize(2, 2);
  line.segments << 0, 1, 1, 2;
  EXPECT_THROW(register_shapes(line, fixtures::knot(30)), InvalidInput);
  EXPECT_THROW(register_shapes(fixtures::knot(30), line), InvalidInput);
  EXPECT_THROW(register_shapes(fixtures::knot(30), fixtures::knot(30), {.samples = 2}), InvalidInput);
  EXPECT_THROW(register_shapes(fixtures::knot(30), fixtures::knot(30), {.trim = 1}), InvalidInput);
  EXPECT_THROW(register_shapes(Shape{}, fixtures::knot(30)), InvalidInput);
}

TEST(RegisterShapes, CanBeCancelled) {
  EXPECT_THROW(register_shapes(fixtures::knot(30), fixtures::knot(30), {},
                               Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

}  // namespace
}  // namespace batten
