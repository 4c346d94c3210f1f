#include "batten/fairing/noise.hpp"

#include "fairing/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using fixtures::closed_sphere;
using fixtures::cube;
using fixtures::Mesh;

// 6 · 32² + 2 draws: their standard deviation is within 3 % of the truth with four standard errors.
TEST(GaussianNoise, MovesAlongTheNormalsByTheAskedDeviation) {
  const Mesh mesh = closed_sphere(32);
  const double edge = mean_edge_length(mesh.positions, mesh.triangles);
  const Points moves = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 7) - mesh.positions;
  EXPECT_NEAR(std::sqrt(moves.rowwise().squaredNorm().mean()) / edge, 0.2, 0.006);
  const Points normals = vertex_normals(mesh.positions, mesh.triangles);
  for (Eigen::Index v = 0; v < moves.rows(); ++v)
    EXPECT_NEAR(std::abs(moves.row(v).dot(normals.row(v))), moves.row(v).norm(), 1e-12);
}

TEST(GaussianNoise, IsTheSameForTheSameSeedOnly) {
  const Mesh mesh = cube(6);
  EXPECT_EQ(add_gaussian_noise(mesh.positions, mesh.triangles, 0.1, 1),
            add_gaussian_noise(mesh.positions, mesh.triangles, 0.1, 1));
  EXPECT_NE(add_gaussian_noise(mesh.positions, mesh.triangles, 0.1, 1),
            add_gaussian_noise(mesh.positions, mesh.triangles, 0.1, 2));
}

// Every hit vertex moves by exactly the amplitude, the others not at all.
TEST(ImpulsiveNoise, HitsTheAskedShareByTheAskedLength) {
  const Mesh mesh = closed_sphere(24);
  const double edge = mean_edge_length(mesh.positions, mesh.triangles);
  for (const ImpulseKind kind : {ImpulseKind::AlongNormal, ImpulseKind::RandomDirection}) {
    const Points moves =
        add_impulsive_noise(mesh.positions, mesh.triangles, 1.0 / 3, 0.5, kind, 3) - mesh.positions;
    Eigen::Index hits = 0;
    for (Eigen::Index v = 0; v < moves.rows(); ++v)
      if (moves.row(v).norm() > 0) {
        ++hits;
        EXPECT_NEAR(moves.row(v).norm(), 0.5 * edge, 1e-12);
      }
    EXPECT_NEAR(static_cast<double>(hits) / static_cast<double>(moves.rows()), 1.0 / 3, 0.03);
  }
}

// (2.36) multiplied by ē: no vertex moves by more than c1 + c2 mean edges, and the noise grows with the mesh.
TEST(ThesisNoise, IsBoundedAndScalesWithTheMesh) {
  const Mesh mesh = cube(8);
  const double edge = mean_edge_length(mesh.positions, mesh.triangles);
  const Points moves = add_thesis_noise(mesh.positions, mesh.triangles, 0.3, 0.2, 5) - mesh.positions;
  EXPECT_LE(moves.rowwise().norm().maxCoeff(), 0.5 * edge * (1 + 1e-12));
  EXPECT_GT(moves.rowwise().norm().maxCoeff(), 0.3 * edge);
  const Points large = 1000 * mesh.positions;
  const Points large_moves = add_thesis_noise(large, mesh.triangles, 0.3, 0.2, 5) - large;
  EXPECT_NEAR((large_moves - 1000 * moves).cwiseAbs().maxCoeff(), 0, 1e-9 * 1000);
}

// Noise of known level, on a sharp and on a round shape, at three scales. The estimate is in edges of the
// noisy mesh, which are longer (8 % at 0.3), and the edges of a cube add to it at 0.1.
TEST(EstimateNoise, FindsTheLevelThatWasAdded) {
  for (const Mesh& mesh : {cube(24), closed_sphere(24)})
    for (const double level : {0.1, 0.2, 0.3})
      for (const double scale : {1e-3, 1.0, 1e3}) {
        const Points clean = scale * mesh.positions;
        const NoiseEstimate estimate =
            estimate_noise(add_gaussian_noise(clean, mesh.triangles, level, 11), mesh.triangles);
        EXPECT_NEAR(estimate.level, level, 0.2 * level + 0.005) << scale;
        EXPECT_EQ(estimate.significance, 1);
        EXPECT_NEAR(estimate.floor, level, 0.15 * level) << scale;
      }
}

TEST(EstimateNoise, CallsCleanShapesClean) {
  for (const Mesh& mesh : {cube(24), closed_sphere(24)}) {
    const NoiseEstimate estimate = estimate_noise(mesh.positions, mesh.triangles);
    EXPECT_LT(estimate.level, 0.03);
    EXPECT_EQ(estimate.significance, 0);
    EXPECT_LT(estimate.floor, 0.005);
  }
  EXPECT_EQ(estimate_noise(Points(0, 3), Triangles(0, 3)).level, 0);
}

TEST(Noise, RefusesLevelsAndSharesOutOfRange) {
  const Mesh mesh = cube(2);
  EXPECT_THROW(add_gaussian_noise(mesh.positions, mesh.triangles, -0.1, 1), InvalidInput);
  EXPECT_THROW(add_impulsive_noise(mesh.positions, mesh.triangles, 1.5, 0.1, ImpulseKind::AlongNormal, 1),
               InvalidInput);
  EXPECT_THROW(add_thesis_noise(mesh.positions, mesh.triangles, 0.1, std::nan(""), 1), InvalidInput);
}

}  // namespace
}  // namespace batten
