#include "batten/fairing/flows.hpp"

#include "fairing/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {
namespace {

using fixtures::closed_sphere;
using fixtures::cube;
using fixtures::Mesh;

double mean_radius(const Points& positions) {
  return positions.rowwise().norm().mean();
}

FlowOptions fixed_steps(double time_step, int steps, bool implicit) {
  FlowOptions options;
  options.time_step = time_step;
  options.steps = steps;
  options.implicit = implicit;
  return options;
}

// ΔX = −2X/R² on a sphere: R² falls by 4t.
TEST(MeanCurvatureFlow, ShrinksASphereAtTheExactRate) {
  const Mesh mesh = closed_sphere(16);
  const double time = 0.02;
  for (const bool implicit : {true, false}) {
    const Points X =
        mean_curvature_flow(mesh.positions, mesh.triangles, fixed_steps(time / 40, 40, implicit));
    EXPECT_NEAR(mean_radius(X), std::sqrt(1 - 4 * time), 0.05 * (1 - std::sqrt(1 - 4 * time))) << implicit;
  }
}

// Backward and forward Euler differ by O(τ): half the step, half the difference.
TEST(MeanCurvatureFlow, ConvergesAtFirstOrderInTime) {
  const Mesh mesh = closed_sphere(8);
  const auto difference = [&](int steps) {
    const double tau = 0.008 / steps;
    return (mean_curvature_flow(mesh.positions, mesh.triangles, fixed_steps(tau, steps, true)) -
            mean_curvature_flow(mesh.positions, mesh.triangles, fixed_steps(tau, steps, false)))
        .norm();
  };
  EXPECT_NEAR(std::log2(difference(8) / difference(16)), 1.0, 0.2);
}

// Δ²X = 4X/R⁴: R⁴ falls by 16t.
TEST(BilaplacianFlow, ShrinksASphereAtTheExactRate) {
  const Mesh mesh = closed_sphere(16);
  const double time = 0.005;
  const Points X = bilaplacian_flow(mesh.positions, mesh.triangles, fixed_steps(time / 40, 40, true));
  const double exact = std::pow(1 - 16 * time, 0.25);
  EXPECT_NEAR(mean_radius(X), exact, 0.12 * (1 - exact));
}

TEST(Flows, LeaveAFlatSheetWithAFixedBorderFlat) {
  const Mesh mesh = fixtures::sheet(8, 8, 1, 1);
  FlowOptions options;
  options.keep_boundary = true;
  options.steps = 3;
  options.time_step = 1e-3;
  // Linear functions are harmonic: not even the inner vertices move.
  EXPECT_LT((mean_curvature_flow(mesh.positions, mesh.triangles, options) - mesh.positions).norm(), 1e-12);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  const Points X = mean_curvature_flow(noisy, mesh.triangles, options);
  for (int i = 0; i <= 8; ++i) EXPECT_EQ(X.row(i), noisy.row(i));
  EXPECT_LT(X.middleRows(9, 63).col(2).norm(), noisy.middleRows(9, 63).col(2).norm());
}

// (2.26) with λ → ∞ stays at X0.
TEST(Flows, AreHeldByFidelity) {
  const Mesh mesh = cube(6);
  FlowOptions options;
  options.fidelity = 1e9;
  EXPECT_LT((mean_curvature_flow(mesh.positions, mesh.triangles, options) - mesh.positions).norm(), 1e-5);
  EXPECT_GT((mean_curvature_flow(mesh.positions, mesh.triangles) - mesh.positions).norm(), 0.1);
}

TEST(Flows, ReportTheThesisStepSizes) {
  const Mesh mesh = closed_sphere(8, 2);
  FlowReport report;
  FlowOptions options;
  options.steps = 1;
  mean_curvature_flow(mesh.positions, mesh.triangles, options, &report);
  // (1.45): ē / max‖ΔX‖, with ΔX = −M⁻¹KX from the operators themselves.
  const Points laplacian = lumped_mass(mesh.positions, mesh.triangles).cwiseInverse().asDiagonal() *
                           (cotangent_stiffness(mesh.positions, mesh.triangles) * mesh.positions);
  EXPECT_NEAR(report.time_step,
              mean_edge_length(mesh.positions, mesh.triangles) / laplacian.rowwise().norm().maxCoeff(),
              1e-9 * report.time_step);
  EXPECT_EQ(report.steps, 1);
  EXPECT_GT(report.largest_move, 0);
}

TEST(EdgeStopping, IsOneOnFlatPartsAndFallsWithCurvature) {
  EXPECT_EQ(edge_stopping(0, 2), 1);
  EXPECT_DOUBLE_EQ(edge_stopping(2, 2), 0.5);
  EXPECT_LT(edge_stopping(20, 2), 0.01);
}

// With a threshold far above every curvature the diffusivity is 1: both are mean curvature flow, the tensor
// form projected on the normals, along which a sphere moves anyway.
TEST(AnisotropicFlows, AreMeanCurvatureFlowWhereNothingIsAnEdge) {
  const Mesh mesh = closed_sphere(10);
  AnisotropicFlowOptions options;
  options.threshold = 1e9;
  options.time_step = 1e-3;
  options.steps = 3;
  const Points plain = mean_curvature_flow(mesh.positions, mesh.triangles, fixed_steps(1e-3, 3, true));
  EXPECT_LT((anisotropic_flow(mesh.positions, mesh.triangles, options) - plain).norm(), 1e-9);
  EXPECT_NEAR(mean_radius(anisotropic_tensor_flow(mesh.positions, mesh.triangles, options)),
              mean_radius(plain), 0.05 * (1 - mean_radius(plain)));
}

// At the edges of a cube mean curvature flow moves fastest; the anisotropic flows hold them back.
TEST(AnisotropicFlows, KeepEdgesThatMeanCurvatureFlowRounds) {
  const Mesh mesh = cube(12);
  AnisotropicFlowOptions options;
  options.threshold = 1.0;
  options.time_step = 2e-3;
  options.steps = 5;
  const auto largest_move = [&](const Points& X) { return (X - mesh.positions).rowwise().norm().maxCoeff(); };
  const double plain = largest_move(mean_curvature_flow(mesh.positions, mesh.triangles,
                                                        fixed_steps(options.time_step, options.steps, true)));
  EXPECT_LT(largest_move(anisotropic_flow(mesh.positions, mesh.triangles, options)), 0.3 * plain);
  EXPECT_LT(largest_move(anisotropic_tensor_flow(mesh.positions, mesh.triangles, options)), 0.6 * plain);
}

// Sharp parts are what the tensor is for: with its own threshold it leaves fewer degrees than mean curvature
// flow after few and after many steps (docs/methods.md#fairing has the figures of real meshes).
TEST(AnisotropicFlows, TensorLeavesLessThanMeanCurvatureFlowOnANoisyCube) {
  const Mesh mesh = cube(14);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.1, 5);
  for (const int steps : {3, 10}) {
    AnisotropicFlowOptions options;
    options.steps = steps;
    FlowOptions plain;
    plain.steps = steps;
    const auto error = [&](const Points& X) {
      return degrees(mean_normal_angle(mesh.positions, X, mesh.triangles));
    };
    EXPECT_LT(error(anisotropic_tensor_flow(noisy, mesh.triangles, options)),
              0.8 * error(mean_curvature_flow(noisy, mesh.triangles, plain)))
        << steps;
  }
}

// The sphere is a minimum of ∫H²; with the curvature vanishing against its own noise hardly anything moves.
TEST(ElasticaFlow, LeavesASphereAlone) {
  const Mesh mesh = closed_sphere(16);
  const Points X = elastica_flow(mesh.positions, mesh.triangles, fixed_steps(1e-4, 10, true));
  const Points bi = bilaplacian_flow(mesh.positions, mesh.triangles, fixed_steps(1e-4, 10, true));
  EXPECT_LT(std::abs(1 - mean_radius(X)), 0.1 * std::abs(1 - mean_radius(bi)));
}

// On a cylinder H = 1/2R and K = 0: it grows with 2H³ = 1/(4R³).
TEST(ElasticaFlow, WidensACylinderAtTheExactRate) {
  Mesh mesh = fixtures::sheet(48, 16, 1, 1);
  // Rolled up; the two borders where the sheet meets itself stay open, far from where it is measured.
  const double R = 0.5;
  for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
    const double angle = 1.8 * kPi * mesh.positions(v, 0), height = mesh.positions(v, 1);
    mesh.positions.row(v) << R * std::cos(angle), R * std::sin(angle), height;
  }
  const double tau = 1e-9;
  const Points X = elastica_flow(mesh.positions, mesh.triangles, fixed_steps(tau, 1, false));
  double speed = 0;
  int count = 0;
  for (int i = 12; i <= 36; ++i)
    for (int j = 6; j <= 10; ++j, ++count)
      speed += (X.row(i * 17 + j).head<2>().norm() - mesh.positions.row(i * 17 + j).head<2>().norm()) / tau;
  EXPECT_NEAR(speed / count, 1 / (4 * R * R * R), 0.05 / (4 * R * R * R));
}

// With W = 1 and no obtuse angles the nonlocal operator is the cotangent Laplacian.
TEST(NonlocalFlow, IsMeanCurvatureFlowWhenEverythingIsSimilar) {
  const Mesh mesh = cube(8);
  NonlocalFlowOptions options;
  options.similarity = 1e12;
  options.time_step = 1e-3;
  options.steps = 1;
  const Points plain = mean_curvature_flow(mesh.positions, mesh.triangles, fixed_steps(1e-3, 1, true));
  EXPECT_LT((nonlocal_flow(mesh.positions, mesh.triangles, options) - plain).norm(), 1e-9);
  options.similarity = 0.01;  // edges are unlike planes
  EXPECT_LT((nonlocal_flow(mesh.positions, mesh.triangles, options) - mesh.positions).norm(),
            0.99 * (plain - mesh.positions).norm());
}

TEST(TaubinSmoothing, SmoothsWithoutShrinking) {
  const Mesh mesh = closed_sphere(16);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 3);
  const Points X = taubin_smoothing(noisy, mesh.triangles);
  EXPECT_NEAR(enclosed_volume(X, mesh.triangles) / enclosed_volume(noisy, mesh.triangles), 1, 0.005);
  EXPECT_LT(fixtures::normal_error_deg(X, mesh.positions, mesh.triangles),
            0.4 * fixtures::normal_error_deg(noisy, mesh.positions, mesh.triangles));
}

TEST(Flows, RefuseBadOptionsAndMeshes) {
  Mesh mesh = cube(3);
  FlowOptions options;
  options.time_step = -1;
  EXPECT_THROW(mean_curvature_flow(mesh.positions, mesh.triangles, options), InvalidInput);
  AnisotropicFlowOptions anisotropic;
  anisotropic.threshold = -1;
  EXPECT_THROW(anisotropic_flow(mesh.positions, mesh.triangles, anisotropic), InvalidInput);
  TaubinOptions taubin;
  taubin.mu = 0.5;
  EXPECT_THROW(taubin_smoothing(mesh.positions, mesh.triangles, taubin), InvalidInput);
  std::swap(mesh.triangles(0, 0), mesh.triangles(0, 1));
  EXPECT_THROW(mean_curvature_flow(mesh.positions, mesh.triangles), InvalidInput);
  EXPECT_EQ(mean_curvature_flow(Points(0, 3), Triangles(0, 3)).rows(), 0);
}

TEST(Flows, CanBeCancelled) {
  const Mesh mesh = cube(3);
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(bilaplacian_flow(mesh.positions, mesh.triangles, {}, nullptr, stop), Cancelled);
  EXPECT_THROW(elastica_flow(mesh.positions, mesh.triangles, {}, nullptr, stop), Cancelled);
}

}  // namespace
}  // namespace batten
