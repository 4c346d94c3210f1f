#include "batten/remeshing/size_field.hpp"

#include "mesh/shapes.hpp"
#include "remeshing/surfaces.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using fixtures::cube;

HalfedgeMesh flat(int n) {
  const Shape shape =
      fixtures::grid(n, n, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  return {shape.positions, shape.triangles};
}

// √(κ1² + κ2²) = √2/r on a sphere; the error falls with the mesh, and half the radius has twice the
// curvature.
TEST(CurvatureMagnitude, IsThatOfASphere) {
  const Shape torus = fixtures::grid(96, 48, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v;
    return Eigen::Vector3d((3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b));
  });
  const HalfedgeMesh mesh(torus.positions, torus.triangles);
  const Eigen::VectorXd found = curvature_magnitude(mesh, {}, 1);
  double worst = 0;
  for (Eigen::Index v = 0; v < found.size(); ++v) {
    const double wide = std::hypot(torus.positions(v, 0), torus.positions(v, 1));
    const double expected = std::hypot(1, (wide - 3) / wide);  // 1 around the tube, cos b / (3 + cos b) along
    worst = std::max(worst, std::abs(found[v] - expected));
  }
  EXPECT_LT(worst, 0.03);
  const HalfedgeMesh half(0.5 * torus.positions, torus.triangles);
  EXPECT_LT((curvature_magnitude(half, {}, 1) - 2 * found).cwiseAbs().maxCoeff(), 1e-9);
}

// Marked creases are breaks and no curvature: a cube has none anywhere.
TEST(CurvatureMagnitude, DoesNotSeeMarkedCreases) {
  const TriangleMesh input = cube(5);
  HalfedgeMesh mesh(input.positions, input.triangles);
  EXPECT_GT(curvature_magnitude(mesh, {}).maxCoeff(), 1);
  FeatureOptions options;
  options.crease_angle = radians(30.0);
  options.corner_angle = radians(40.0);
  const FeatureChains chains = mark_features(mesh, options);
  EXPECT_LT(curvature_magnitude(mesh, chains).maxCoeff(), 1e-6);
}

// A plane of equilateral triangles of edge h has 2/(√3 h²) vertices per area.
TEST(VerticesForSizes, IsExactForOneSize) {
  const HalfedgeMesh mesh = flat(7);
  for (const double h : {0.1, 0.02}) {
    const Eigen::VectorXd sizes = Eigen::VectorXd::Constant(mesh.vertex_capacity(), h);
    EXPECT_NEAR(vertices_for_sizes(mesh, sizes), 2 / (std::sqrt(3.0) * h * h), 1e-9 / (h * h));
  }
}

// What is left changes by at most the gradation along every edge, nothing is raised, and no vertex could keep
// more: it has its own size or hangs on a neighbour's.
TEST(LimitGradation, LowersSizesAsFarAsItMustAndNoFurther) {
  const HalfedgeMesh mesh = flat(12);
  Random random(4);
  Eigen::VectorXd given(mesh.vertex_capacity());
  for (Eigen::Index v = 0; v < given.size(); ++v) given[v] = 0.05 + random.uniform();
  Eigen::VectorXd sizes = given;
  const double gradation = 0.4;
  limit_gradation(mesh, gradation, sizes);
  int lowered = 0;
  for (int v = 0; v < mesh.vertex_capacity(); ++v) {
    EXPECT_LE(sizes[v], given[v]);
    double least = given[v];
    mesh.for_each_neighbour(v, [&](int u) {
      least = std::min(least, sizes[u] + gradation * (mesh.position(u) - mesh.position(v)).norm());
    });
    EXPECT_NEAR(sizes[v], least, 1e-15) << v;
    lowered += sizes[v] < given[v] ? 1 : 0;
  }
  EXPECT_GT(lowered, 50);
}

// Adaptive or not, as many vertices: the sizes are scaled to that. Where the surface bends they are smaller,
// within the range; without adaptivity they are one.
TEST(AdaptiveSizes, KeepTheNumberOfVertices) {
  const HalfedgeMesh mesh = flat(20);
  Eigen::VectorXd curvature(mesh.vertex_capacity());
  for (int v = 0; v < mesh.vertex_capacity(); ++v) curvature[v] = mesh.position(v).x() < 0.5 ? 0.5 : 8;
  const double mean = 0.05;
  const Eigen::VectorXd even = adaptive_sizes(mesh, curvature, mean, 0, 0.3);
  EXPECT_EQ(even, Eigen::VectorXd::Constant(even.size(), mean));
  for (const double adaptivity : {0.5, 1.0}) {
    const Eigen::VectorXd sizes = adaptive_sizes(mesh, curvature, mean, adaptivity, 1e9);
    EXPECT_NEAR(vertices_for_sizes(mesh, sizes), vertices_for_sizes(mesh, even), 1e-6 / (mean * mean));
    // Without a limit of gradation: the ratio is (κ1/κ2)^(a/2).
    EXPECT_NEAR(sizes[0] / sizes[mesh.vertex_capacity() - 1], std::pow(16, adaptivity / 2), 1e-9);
  }
}

}  // namespace
}  // namespace batten
