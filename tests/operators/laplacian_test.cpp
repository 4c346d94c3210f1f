#include "batten/operators/laplacian.hpp"

#include "operators/sample_meshes.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/operators/curvature.hpp"

namespace batten {
namespace {

using samples::octasphere;
using samples::square;
using samples::torus;

Eigen::MatrixXd dense(const SparseMatrix& m) {
  return Eigen::MatrixXd(m);
}

TEST(CotangentStiffness, IsSymmetricPositiveSemiDefiniteWithZeroRowSums) {
  const TriangleMesh mesh = square(7, 0.6);
  const Eigen::MatrixXd K = dense(cotangent_stiffness(mesh.positions, mesh.triangles));
  EXPECT_LT((K - K.transpose()).norm(), 1e-13);
  EXPECT_LT(K.rowwise().sum().norm(), 1e-12);
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
  EXPECT_GT(eigenvalues[0], -1e-12);
  EXPECT_GT(eigenvalues[1], 1e-3);  // constants alone
}

// A linear function has no Laplacian; on a plane the cotangent stiffness says so exactly, however irregular.
TEST(CotangentStiffness, AnnulsLinearFunctionsInsideAPlane) {
  const TriangleMesh mesh = square(12, 0.7);
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  const Eigen::VectorXd f = 2 * mesh.positions.col(0) - 3 * mesh.positions.col(1);
  const Eigen::VectorXd Kf = K * f;
  const std::vector<char> border = border_vertices(mesh.triangles, mesh.n_vertices());
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    if (!border[v]) {
      EXPECT_NEAR(Kf[v], 0, 1e-13);
    }
}

// Two sides of 1 at a right angle: cot 45° = 1, cot 90° = 0, by hand.
TEST(CotangentStiffness, HasTheWeightsOfARightTriangle) {
  TriangleMesh mesh;
  mesh.positions.resize(3, 3);
  mesh.positions << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  Eigen::Matrix3d expected;
  expected << 1, -0.5, -0.5, -0.5, 0.5, 0, -0.5, 0, 0.5;
  EXPECT_LT((dense(cotangent_stiffness(mesh.positions, mesh.triangles)) - expected).norm(), 1e-15);
}

TEST(CotangentStiffness, StaysFiniteOnTrianglesWithoutArea) {
  TriangleMesh mesh = square(4);
  mesh.positions.row(5) = mesh.positions.row(6);
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  EXPECT_TRUE(dense(K).allFinite());
}

TEST(CotangentStiffness, NamesTheTriangleWithAWrongIndex) {
  TriangleMesh mesh = square(3);
  EdgeLengths lengths = edge_lengths(mesh.positions, mesh.triangles);
  mesh.triangles(2, 1) = 99;
  EXPECT_THROW(cotangent_stiffness(mesh.triangles, lengths, mesh.n_vertices()), InvalidInput);
}

TEST(LumpedMass, SumsToTheAreaInBothKinds) {
  const TriangleMesh mesh = square(9, 0.8);
  EXPECT_NEAR(lumped_mass(mesh.positions, mesh.triangles).sum(), 1, 1e-13);
  EXPECT_NEAR(lumped_mass(mesh.positions, mesh.triangles, MassKind::Barycentric).sum(), 1, 1e-13);
}

// The counter-example to S algorithm 2.11 (docs/errata.md#s-2-11): printed it gives −1.6, −1.6, +0.5 of this
// triangle.
TEST(LumpedMass, SharesAnObtuseTriangleQuarterQuarterHalf) {
  Points positions(3, 3);
  positions << 0, 0, 0, 4, 0, 0, 2, 0.5, 0;
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  const Eigen::VectorXd mass = lumped_mass(positions, triangles);
  EXPECT_NEAR(mass[0], 0.25, 1e-15);
  EXPECT_NEAR(mass[1], 0.25, 1e-15);
  EXPECT_NEAR(mass[2], 0.5, 1e-15);
}

TEST(UniformStiffness, HasDegreesOnTheDiagonal) {
  const TriangleMesh mesh = octasphere(1, 1);  // the octahedron: six vertices of degree four
  const Eigen::MatrixXd K = dense(uniform_stiffness(mesh.triangles, mesh.n_vertices()));
  for (int v = 0; v < 6; ++v) EXPECT_EQ(K(v, v), 4);
  EXPECT_EQ(K.rowwise().sum().norm(), 0);
}

// A second implementation: the product of the three matrices, then its rows and columns.
TEST(SquaredStiffness, EqualsTheProductOfTheMatrices) {
  const TriangleMesh mesh = torus(5);
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  const Eigen::VectorXd d = lumped_mass(mesh.positions, mesh.triangles).cwiseInverse();
  const Eigen::Index n = K.rows();
  std::vector<int> unknown(n, -1), known(n, -1), order_u, order_k;
  for (int v = 0; v < n; ++v)
    if (v % 3 == 0) {
      known[v] = static_cast<int>(order_k.size());
      order_k.push_back(v);
    } else {
      unknown[v] = static_cast<int>(order_u.size());
      order_u.push_back(v);
    }
  const SquaredStiffness squared = squared_stiffness(K, d, unknown, known);
  const Eigen::MatrixXd whole = dense(K) * d.asDiagonal() * dense(K);
  const Eigen::MatrixXd lower = dense(squared.lower), right = dense(squared.known);
  for (std::size_t i = 0; i < order_u.size(); ++i) {
    for (std::size_t j = 0; j < order_u.size(); ++j)
      EXPECT_NEAR(lower(i, j), i >= j ? whole(order_u[i], order_u[j]) : 0, 1e-11);
    for (std::size_t j = 0; j < order_k.size(); ++j)
      EXPECT_NEAR(right(i, j), whole(order_u[i], order_k[j]), 1e-11);
  }
}

/// The sides of one triangle, each opposite its corner.
EdgeLengths sides(double a, double b, double c) {
  return (EdgeLengths(1, 3) << a, b, c).finished();
}

// Corner 0 of the needle has the angle 1e-6 and so a cotangent of 1e6, the others are almost right angles. Of
// a triangle without area the angles are π opposite the longest side and 0: cotangents −∞ and +∞.
TEST(CotangentStiffness, HoldsNeedlesAndFlatTrianglesWithinTheBound) {
  const Triangles one = (Triangles(1, 3) << 0, 1, 2).finished();
  for (const double bound : {1e3, 20.0}) {
    const Eigen::MatrixXd needle = cotangent_stiffness(one, sides(1e-6, 1, 1), 3, {bound});
    EXPECT_DOUBLE_EQ(needle(1, 2), -0.5 * bound);
    EXPECT_NEAR(needle(0, 1), 0, 1e-6);
    const Eigen::MatrixXd flat = cotangent_stiffness(one, sides(2, 1, 1), 3, {bound});
    EXPECT_DOUBLE_EQ(flat(1, 2), 0.5 * bound);
    EXPECT_DOUBLE_EQ(flat(0, 1), -0.5 * bound);
    EXPECT_DOUBLE_EQ(flat(0, 2), -0.5 * bound);
  }
}

// Every edge counts once, whether one triangle has it or two.
TEST(UniformStiffness, IsTheGraphLaplacianAlsoOnBorders) {
  const Triangles two = (Triangles(2, 3) << 0, 1, 2, 2, 1, 3).finished();
  Eigen::Matrix4d expected;
  expected << 2, -1, -1, 0, -1, 3, -1, -1, -1, -1, 3, -1, 0, -1, -1, 2;
  EXPECT_EQ(Eigen::MatrixXd(uniform_stiffness(two, 4)), Eigen::MatrixXd(expected));
}

TEST(CotangentStiffness, NamesABoundOutOfRange) {
  EXPECT_FALSE(CotangentOptions().problem());
  EXPECT_EQ(CotangentOptions{-2}.problem(), "bound must be finite and above 0, got -2");
  const Triangles one = (Triangles(1, 3) << 0, 1, 2).finished();
  for (const double bound : {0.0, -1.0, static_cast<double>(INFINITY), static_cast<double>(NAN)})
    EXPECT_THROW(cotangent_stiffness(one, sides(1, 1, 1), 3, {bound}), InvalidInput) << bound;
}

}  // namespace
}  // namespace batten
