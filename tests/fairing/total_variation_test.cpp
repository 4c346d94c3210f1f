#include "batten/fairing/total_variation.hpp"

#include "fairing/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using Eigen::MatrixXd;
using fixtures::Mesh;
using fixtures::sheet;

// ∫|∇x| over the unit square is 1; of a constant 0.
TEST(TotalVariation, OfALinearFunctionIsItsSlopeTimesTheArea) {
  const Mesh mesh = sheet(9, 7, 1, 1);
  EXPECT_NEAR(total_variation(mesh.positions, mesh.triangles, mesh.positions.col(0)), 1, 1e-12);
  EXPECT_NEAR(total_variation(mesh.positions, mesh.triangles, MatrixXd(3 * mesh.positions.col(1))), 3, 1e-12);
  EXPECT_NEAR(total_variation(mesh.positions, mesh.triangles, MatrixXd::Ones(mesh.positions.rows(), 1)), 0,
              1e-12);
}

// Exact answer [strong2003]: a step between two rectangles of width w comes back lowered by
// 1/(μ w) on either side, its place unchanged. Here w = 1 and μ = 10: ±1 becomes ±0.9.
TEST(DenoiseTotalVariation, LowersAStepByTheExactAmount) {
  const Mesh mesh = sheet(11, 4, 2, 1);
  MatrixXd field(mesh.positions.rows(), 1);
  for (Eigen::Index v = 0; v < field.rows(); ++v) field(v, 0) = mesh.positions(v, 0) < 1 ? -1 : 1;
  TotalVariationOptions options;
  options.fit_weight = 10;
  options.iterations = 5000;
  TotalVariationReport report;
  const MatrixXd result = denoise_total_variation(mesh.positions, mesh.triangles, field, options, &report);
  for (Eigen::Index v = 0; v < field.rows(); ++v) EXPECT_NEAR(result(v, 0), 0.9 * field(v, 0), 0.015);
  EXPECT_GE(report.gap, -1e-9);
  EXPECT_LT(report.gap, 0.01 * report.energy);
}

// The duality gap bounds the distance from the optimum and falls with the iterations: τ is small enough.
TEST(DenoiseTotalVariation, ConvergesAsTheDualityGapShows) {
  const Mesh mesh = fixtures::closed_sphere(8);
  Random random(3);
  MatrixXd field(mesh.positions.rows(), 2);
  for (Eigen::Index v = 0; v < field.rows(); ++v)
    field.row(v) << mesh.positions(v, 0) + 0.3 * random.normal(),
        mesh.positions(v, 1) + 0.3 * random.normal();
  double last_gap = 1e300;
  TotalVariationOptions options;
  options.fit_weight = 5;
  for (const int iterations : {20, 200, 2000}) {
    options.iterations = iterations;
    TotalVariationReport report;
    denoise_total_variation(mesh.positions, mesh.triangles, field, options, &report);
    EXPECT_GE(report.gap, -1e-9);
    EXPECT_LT(report.gap, 0.5 * last_gap);
    last_gap = report.gap;
  }
}

// The L1 fit drops a lone outlier altogether and, unlike L2, leaves the contrast of a step as it is.
TEST(DenoiseTotalVariation, WithL1FitRemovesOutliersAndKeepsContrast) {
  const Mesh mesh = sheet(20, 10, 2, 1);
  MatrixXd field(mesh.positions.rows(), 1);
  for (Eigen::Index v = 0; v < field.rows(); ++v) field(v, 0) = mesh.positions(v, 0) < 1.01 ? -1 : 1;
  MatrixXd spoiled = field;
  const Eigen::Index outlier = 4 * 11 + 5;
  spoiled(outlier, 0) = 5;
  TotalVariationOptions options;
  options.fit = TotalVariationFit::L1;
  options.fit_weight = 6;  // above the perimeter over area of the halves, 1…3, below that of one vertex, 40
  options.iterations = 600;
  const MatrixXd result = denoise_total_variation(mesh.positions, mesh.triangles, spoiled, options);
  EXPECT_NEAR(result(outlier, 0), -1, 0.1);
  EXPECT_NEAR(result(2 * 11 + 5, 0), -1, 0.05);
  EXPECT_NEAR(result(17 * 11 + 5, 0), 1, 0.05);
}

TEST(DenoiseTotalVariation, ReturnsTheDataForAVeryStrongFit) {
  const Mesh mesh = sheet(5, 5, 1, 1);
  TotalVariationOptions options;
  options.fit_weight = 1e9;
  const MatrixXd field = mesh.positions.col(0).cwiseAbs2();
  EXPECT_LT((denoise_total_variation(mesh.positions, mesh.triangles, field, options) - field).norm(), 1e-6);
}

TEST(DenoiseTotalVariation, RefusesBadOptionsAndSizes) {
  const Mesh mesh = sheet(2, 2, 1, 1);
  TotalVariationOptions options;
  options.fit_weight = 0;
  EXPECT_THROW(denoise_total_variation(mesh.positions, mesh.triangles, mesh.positions, options),
               InvalidInput);
  EXPECT_THROW(denoise_total_variation(mesh.positions, mesh.triangles, MatrixXd::Zero(3, 1)), InvalidInput);
}

}  // namespace
}  // namespace batten
