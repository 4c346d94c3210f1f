#include "batten/linalg/sparse_cholesky.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

/// The five-point Laplacian of an n × n grid plus `shift` on the diagonal: positive definite for shift ≥ 0.
SparseMatrix grid_laplacian(int n, double shift) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int k = i * n + j;
      entries.emplace_back(k, k, 4 + shift);
      if (i + 1 < n) entries.emplace_back(k, k + n, -1), entries.emplace_back(k + n, k, -1);
      if (j + 1 < n) entries.emplace_back(k, k + 1, -1), entries.emplace_back(k + 1, k, -1);
    }
  }
  SparseMatrix A(n * n, n * n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

std::vector<CholeskyBackend> backends() {
  std::vector<CholeskyBackend> list{CholeskyBackend::Auto, CholeskyBackend::Eigen};
  if (SparseCholesky::has_cholmod()) list.push_back(CholeskyBackend::Cholmod);
  return list;
}

TEST(SparseCholesky, SolvesForSeveralRightHandSides) {
  for (const CholeskyBackend backend : backends()) {
    const SparseMatrix A = grid_laplacian(20, 0);
    SparseCholesky solver("grid", backend);
    solver.factorize(A);
    Random random(1);
    const Eigen::MatrixXd X = Eigen::MatrixXd::NullaryExpr(400, 3, [&] { return random.normal(); });
    EXPECT_LT((solver.solve(A * X) - X).norm(), 1e-11 * X.norm());
  }
}

// The seven-point Laplacian of a cube fills in so much that another ordering is tried; new values then reuse
// it.
TEST(SparseCholesky, SolvesSystemsThatFillIn) {
  constexpr int n = 24;
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n * n * n; ++k) {
    entries.emplace_back(k, k, 6);
    if (k % n > 0) entries.emplace_back(k, k - 1, -1);
    if (k / n % n > 0) entries.emplace_back(k, k - n, -1);
    if (k / (n * n) > 0) entries.emplace_back(k, k - n * n, -1);
  }
  SparseMatrix lower(n * n * n, n * n * n);
  lower.setFromTriplets(entries.begin(), entries.end());
  SparseCholesky solver("cube");
  for (const double scale : {1.0, 3.0}) {
    const SparseMatrix scaled = scale * lower;
    const SparseMatrix A = scaled.selfadjointView<Eigen::Lower>();
    solver.factorize(scaled);
    Random random(2);
    const Eigen::MatrixXd X = Eigen::MatrixXd::NullaryExpr(A.rows(), 2, [&] { return random.normal(); });
    EXPECT_LT((solver.solve(A * X) - X).norm(), 1e-11 * X.norm());
  }
}

TEST(SparseCholesky, ReadsTheLowerTriangleOnly) {
  for (const CholeskyBackend backend : backends()) {
    const SparseMatrix A = grid_laplacian(8, 1);
    SparseCholesky full("grid", backend), lower("grid", backend);
    full.factorize(A);
    lower.factorize(A.triangularView<Eigen::Lower>());
    const Eigen::VectorXd b = Eigen::VectorXd::Ones(64);
    EXPECT_LT((full.solve(b) - lower.solve(b)).norm(), 1e-13);
  }
}

TEST(SparseCholesky, TakesNewValuesAndNewPatterns) {
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("grid", backend);
    for (const double shift : {0.0, 1.0, 5.0}) {
      for (const int n : {5, 9}) {
        const SparseMatrix A = grid_laplacian(n, shift);
        solver.factorize(A);
        const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n * n, -1, 1);
        EXPECT_LT((solver.solve(A * x) - x).norm(), 1e-10);
      }
    }
  }
}

TEST(SparseCholesky, RefusesSingularIndefiniteAndNotFinite) {
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("test system", backend);
    SparseMatrix A = grid_laplacian(4, -5);
    EXPECT_THROW(solver.factorize(A), SolverFailure);
    A = grid_laplacian(4, 0);
    A.coeffRef(3, 3) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(
        {
          solver.factorize(A);
          solver.solve(Eigen::VectorXd::Ones(16));
        },
        SolverFailure);
    SparseMatrix zero(3, 3);
    EXPECT_THROW(
        {
          solver.factorize(zero);
          solver.solve(Eigen::VectorXd::Ones(3));
        },
        SolverFailure);
    EXPECT_THROW(SparseCholesky("never factorised", backend).solve(Eigen::VectorXd::Ones(3)), SolverFailure);
  }
}

TEST(SparseCholesky, AcceptsTheEmptySystem) {
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("empty", backend);
    solver.factorize(SparseMatrix(0, 0));
    EXPECT_EQ(solver.solve(Eigen::MatrixXd(0, 3)).cols(), 3);
  }
}

}  // namespace
}  // namespace batten
