#include "batten/fairing/surface_diffusion.hpp"

#include "fairing/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {
namespace {

using fixtures::closed_sphere;
using fixtures::cube;
using fixtures::Mesh;

// With W = 1, one step and λ → 0 both steps together are implicit mean curvature flow with the same fixed L
// (docs/errata.md#h-2-31), up to the translation that λ alone holds.
TEST(SurfaceDiffusion, IsImplicitMeanCurvatureFlowWithoutFidelity) {
  const Mesh mesh = cube(6);
  SurfaceDiffusionOptions options;
  options.nonlocal = false;
  options.steps = 1;
  options.time_step = 0.7;
  options.fidelity = 1e-8;
  const Points X = surface_diffusion(mesh.positions, mesh.triangles, options);
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  const Eigen::VectorXd D = K.diagonal();
  SparseCholesky solver("test");
  solver.factorize(options.time_step * K + SparseMatrix(D.asDiagonal()));
  const Points flow = solver.solve(D.asDiagonal() * mesh.positions);
  const auto centred = [](const Points& points) {
    return Points(points.rowwise() - points.colwise().mean());
  };
  EXPECT_LT((centred(X) - centred(flow)).rowwise().norm().maxCoeff(), 1e-4);
  EXPECT_GT((X - mesh.positions).norm(), 0.1);
}

// (2.33) without diffusion: the curvature that is asked for is that of the input, for either form.
TEST(SurfaceDiffusion, WithoutStepsReturnsTheInput) {
  const Mesh mesh = closed_sphere(8);
  SurfaceDiffusionOptions options;
  options.steps = 0;
  EXPECT_LT((surface_diffusion(mesh.positions, mesh.triangles, options) - mesh.positions).norm(), 1e-9);
}

// Table 2.2's roles: both smooth the noise; at the edges of a cube the similarity weights keep more.
TEST(SurfaceDiffusion, SmoothsNoiseAndKeepsEdgesBetterWithSimilarity) {
  const Mesh round = closed_sphere(16);
  const Points noisy = add_gaussian_noise(round.positions, round.triangles, 0.1, 2);
  for (const bool scalar : {false, true}) {
    SurfaceDiffusionOptions options;
    options.scalar = scalar;
    const Points X = surface_diffusion(noisy, round.triangles, options);
    EXPECT_LT(fixtures::normal_error_deg(X, round.positions, round.triangles),
              0.8 * fixtures::normal_error_deg(noisy, round.positions, round.triangles));
    EXPECT_NEAR(enclosed_volume(X, round.triangles) / enclosed_volume(noisy, round.triangles), 1, 0.05);
  }
  const Mesh sharp = cube(12);
  SurfaceDiffusionOptions options;
  options.similarity = 0.05;
  const auto move = [&] {
    return (surface_diffusion(sharp.positions, sharp.triangles, options) - sharp.positions).norm();
  };
  const double nonlocal = move();
  options.nonlocal = false;
  EXPECT_LT(nonlocal, 0.8 * move());
}

TEST(SurfaceDiffusion, RefusesBadOptionsAndCanBeCancelled) {
  const Mesh mesh = cube(3);
  SurfaceDiffusionOptions options;
  options.fidelity = 0;
  EXPECT_THROW(surface_diffusion(mesh.positions, mesh.triangles, options), InvalidInput);
  options.fidelity = 0.5;
  options.similarity = 0;
  EXPECT_THROW(surface_diffusion(mesh.positions, mesh.triangles, options), InvalidInput);
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(surface_diffusion(mesh.positions, mesh.triangles, {}, nullptr, stop), Cancelled);
}

}  // namespace
}  // namespace batten
