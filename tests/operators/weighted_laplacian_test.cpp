#include "batten/operators/weighted_laplacian.hpp"

#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr LaplacianWeights kAll[] = {LaplacianWeights::Cotangent, LaplacianWeights::Umbrella,
                                     LaplacianWeights::ScaledUmbrella, LaplacianWeights::MeanValue};

/// n × n vertices of a lattice of equilateral triangles with the edge `e`.
TriangleMesh lattice(int n, double e) {
  return samples::mapped_grid(n, n, false, false, [=](double u, double v) {
    const double i = u * (n - 1), j = v * (n - 1);
    return Eigen::Vector3d(e * (i - 0.5 * j), e * std::sqrt(0.75) * j, 0);
  });
}

/// Marks vertices from which a border is at least `rings` edges away.
std::vector<char> inside(const TriangleMesh& mesh, int rings) {
  std::vector<char> near = border_vertices(mesh.triangles, mesh.n_vertices());
  for (int ring = 1; ring < rings; ++ring) {
    const std::vector<char> old = near;
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
      for (int k = 0; k < 3; ++k)
        if (old[mesh.triangles(f, k)])
          for (int i = 0; i < 3; ++i) near[mesh.triangles(f, i)] = 1;
  }
  for (char& mark : near) mark = !mark;
  return near;
}

// Constants have no Laplacian, and nothing else does (rank n − 1 on a connected mesh, n − 2 on two parts).
TEST(WeightedLaplacian, AnnulsConstantsOfEachComponentAlone) {
  const TriangleMesh one = samples::square(5, 0.5);
  TriangleMesh two;
  const Eigen::Index n = one.n_vertices(), m = one.n_triangles();
  two.positions.resize(2 * n, 3);
  two.positions << one.positions, one.positions.rowwise() + Eigen::RowVector3d(3, 0, 0);
  two.triangles.resize(2 * m, 3);
  two.triangles << one.triangles, one.triangles.array() + static_cast<int>(n);
  for (const LaplacianWeights weights : kAll) {
    const MatrixXd L = weighted_laplacian(one.positions, one.triangles, weights);
    EXPECT_LT(L.rowwise().sum().cwiseAbs().maxCoeff(), 1e-9 * L.cwiseAbs().maxCoeff());
    EXPECT_EQ(L.fullPivLu().rank(), n - 1);
    EXPECT_EQ(MatrixXd(weighted_laplacian(two.positions, two.triangles, weights)).fullPivLu().rank(),
              2 * n - 2);
    EXPECT_LT(L.diagonal().maxCoeff(), 0);  // a peak goes down
  }
}

// On equilateral triangles f = x² + y² has the six neighbours e² higher each: Δf = 4 exactly, the mean of the
// neighbours is e² = (e²/4) Δf above (docs/errata.md#h-1-16), and the scaled umbrella is 2/e² times that.
TEST(WeightedLaplacian, HasTheKnownMultiplesOfTheLaplacianOnEquilateralTriangles) {
  const double e = 0.3;
  const TriangleMesh mesh = lattice(7, e);
  const VectorXd f = mesh.positions.rowwise().squaredNorm();
  const double expected[] = {4, e * e, 2, e * e};
  const std::vector<char> is_inside = inside(mesh, 1);
  for (int k = 0; k < 4; ++k) {
    const VectorXd Lf = weighted_laplacian(mesh.positions, mesh.triangles, kAll[k]) * f;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
      if (is_inside[v]) {
        EXPECT_NEAR(Lf[v], expected[k], 1e-11);
      }
  }
}

// Cotangent and mean value weights know the angles: linear functions on an irregular plane stay. The
// umbrellas pull vertices sideways (H 1.3), the scaled one less.
TEST(WeightedLaplacian, TellsLinearFunctionsOnAPlaneByCotangentsAndMeanValues) {
  const TriangleMesh mesh = samples::square(9, 0.6);
  const double e = 1.0 / 8;
  const VectorXd f = 2 * mesh.positions.col(0) - 3 * mesh.positions.col(1);
  const std::vector<char> is_inside = inside(mesh, 1);
  double largest[4] = {0, 0, 0, 0};
  for (int k = 0; k < 4; ++k) {
    const VectorXd Lf = weighted_laplacian(mesh.positions, mesh.triangles, kAll[k]) * f;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
      if (is_inside[v]) largest[k] = std::max(largest[k], std::abs(Lf[v]));
  }
  EXPECT_LT(largest[0], 1e-10);
  EXPECT_LT(largest[3], 1e-12);
  EXPECT_GT(largest[1], 0.1 * e);
  EXPECT_GT(largest[2], 0.1 / e);
}

// The matrices that the rooms assemble are the symmetric halves of these.
TEST(WeightedLaplacian, IsMassAndStiffnessDivided) {
  const TriangleMesh mesh = samples::torus(6);
  const MatrixXd K = cotangent_stiffness(mesh.positions, mesh.triangles);
  const VectorXd mass = lumped_mass(mesh.positions, mesh.triangles);
  const MatrixXd L = weighted_laplacian(mesh.positions, mesh.triangles, LaplacianWeights::Cotangent);
  EXPECT_LT((mass.asDiagonal() * L + K).norm(), 1e-12);
  const MatrixXd S = uniform_stiffness(mesh.triangles, mesh.n_vertices());
  const MatrixXd U = weighted_laplacian(mesh.positions, mesh.triangles, LaplacianWeights::Umbrella);
  EXPECT_LT((MatrixXd(S.diagonal().asDiagonal() * U) + S).norm(), 1e-12);
}

// Length scales by 10: weights of unit 1/length² by 1/100, those without unit not at all.
TEST(WeightedLaplacian, ScalesWithTheUnitsOfItsWeights) {
  const TriangleMesh mesh = samples::square(5, 0.5);
  const double factor[] = {0.01, 1, 0.01, 1};
  for (int k = 0; k < 4; ++k) {
    const MatrixXd L = weighted_laplacian(mesh.positions, mesh.triangles, kAll[k]);
    const MatrixXd scaled = weighted_laplacian(10 * mesh.positions, mesh.triangles, kAll[k]);
    EXPECT_LT((scaled - factor[k] * L).norm(), 1e-12 * L.norm());
  }
}

TEST(WeightedLaplacian, StaysFiniteOnBadTrianglesAndLonelyVertices) {
  TriangleMesh mesh = samples::square(5, 0.5);
  mesh.positions.row(7) = mesh.positions.row(8);  // an edge without length
  mesh.positions.conservativeResize(mesh.n_vertices() + 1, 3);
  mesh.positions.row(mesh.n_vertices() - 1).setZero();  // a vertex without triangles
  for (const LaplacianWeights weights : kAll) {
    const MatrixXd L = weighted_laplacian(mesh.positions, mesh.triangles, weights);
    EXPECT_TRUE(L.allFinite());
    EXPECT_EQ(L.row(mesh.n_vertices() - 1).norm(), 0);
  }
  mesh.triangles(3, 1) = 99;
  for (const LaplacianWeights weights : kAll)
    EXPECT_THROW(weighted_laplacian(mesh.positions, mesh.triangles, weights), InvalidInput);
}

// On equilateral triangles Δ_h f = Δf + (e²/16) Δ²f + …, so Δ_h² of r⁴ is 64 = Δ² r⁴ exactly, and Δ_h³ is 0.
TEST(LaplacianPower, IsExactForTheFourthPowerOnEquilateralTriangles) {
  const TriangleMesh mesh = lattice(13, 0.2);
  const Points centred = mesh.positions.rowwise() - mesh.positions.colwise().mean();
  const VectorXd f = centred.rowwise().squaredNorm().cwiseAbs2();
  const SparseMatrix L = weighted_laplacian(mesh.positions, mesh.triangles, LaplacianWeights::Cotangent);
  const VectorXd second = laplacian_power(L, 2) * f, third = laplacian_power(L, 3) * f;
  const std::vector<char> two_in = inside(mesh, 2), three_in = inside(mesh, 3);
  int checked = 0;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    if (two_in[v]) {
      EXPECT_NEAR(second[v], 64, 1e-8);
    }
    if (three_in[v]) {
      EXPECT_NEAR(third[v], 0, 1e-5);
      ++checked;
    }
  }
  EXPECT_GT(checked, 40);
}

TEST(LaplacianPower, IsRepeatedApplication) {
  const TriangleMesh mesh = samples::torus(6);
  const SparseMatrix L = weighted_laplacian(mesh.positions, mesh.triangles, LaplacianWeights::MeanValue);
  const VectorXd f = mesh.positions.col(0);
  EXPECT_LT((laplacian_power(L, 3) * f - L * (L * (L * f))).norm(), 1e-12);
  EXPECT_EQ(laplacian_power(L, 0) * f, f);
  EXPECT_THROW(laplacian_power(L, -1), InvalidInput);
  EXPECT_THROW(laplacian_power(SparseMatrix(3, 4), 2), InvalidInput);
}

}  // namespace
}  // namespace batten
