#include "batten/linalg/iterative.hpp"

#include "linalg/systems.hpp"
#include "threads.hpp"

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using fixtures::kTight;
using fixtures::random_sparse;

TEST(Iterative, ConjugateGradientsSolvesNormalEquations) {
  const SparseMatrix R = random_sparse(80, 60, 1);
  SparseMatrix A = R.transpose() * R;
  Eigen::MatrixXd X_true = Eigen::MatrixXd::Random(60, 2), X;
  const IterativeReport report = solve_conjugate_gradients(A, A * X_true, X, "test", kTight);
  EXPECT_TRUE(report.converged);
  EXPECT_LT((X - X_true).norm(), 1e-7);
}

TEST(Iterative, ConjugateGradientsTakesADiagonalPreconditioner) {
  const SparseMatrix R = random_sparse(80, 60, 1);
  SparseMatrix A = R.transpose() * R;
  for (int i = 0; i < 60; ++i) A.coeffRef(i, i) += 1;
  IterativeOptions options = kTight;
  options.preconditioner = Preconditioner::Diagonal;
  const Eigen::MatrixXd X_true = Eigen::MatrixXd::Random(60, 2);
  Eigen::MatrixXd X;
  const IterativeReport report = solve_conjugate_gradients(A, A * X_true, X, "test", options);
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.residual, options.tolerance);
  EXPECT_LT((X - X_true).norm(), 1e-7);

  options.max_iterations = 2;
  const IterativeReport stopped =
      solve_conjugate_gradients(A, A * X_true, X = Eigen::MatrixXd::Zero(60, 2), "test", options);
  EXPECT_FALSE(stopped.converged);
  EXPECT_GT(stopped.residual, options.tolerance);
  EXPECT_EQ(stopped.iterations, 2);
}

// D is its own inverse's oracle: with D as preconditioner one step is exact.
TEST(Iterative, ConjugateGradientsOfAnOperatorUsesItsPreconditioner) {
  const Eigen::VectorXd D = Eigen::VectorXd::LinSpaced(30000, 1, 9), b = Eigen::VectorXd::Ones(30000);
  const LinearOperator product = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y = D.cwiseProduct(x); };
  Eigen::VectorXd x;
  const IterativeReport report = solve_conjugate_gradients(product, D, b, x, "diagonal", kTight);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_LT((x - b.cwiseQuotient(D)).norm(), 1e-12 * x.norm());
  // From the solution there is nothing to do; for nothing the answer is nothing.
  EXPECT_EQ(solve_conjugate_gradients(product, D, b, x, "diagonal", kTight).iterations, 0);
  EXPECT_TRUE(solve_conjugate_gradients(product, D, 0 * b, x, "diagonal", kTight).converged);
  EXPECT_EQ(x.norm(), 0);
  EXPECT_THROW(solve_conjugate_gradients(product, 0 * D, b, x, "diagonal", kTight), SolverFailure);
  EXPECT_THROW(solve_conjugate_gradients(product, D, b / 0.0, x, "diagonal", kTight), SolverFailure);
}

TEST(Iterative, ConjugateGradientsGivesTheSameBitsOnAnyNumberOfThreads) {
  const SparseMatrix R = random_sparse(30000, 20000, 4);
  SparseMatrix A = R.transpose() * R;
  for (int i = 0; i < A.rows(); ++i) A.coeffRef(i, i) += 1;
  IterativeOptions options;
  options.preconditioner = Preconditioner::Diagonal;
  const auto solve = [&](int threads) {
    const test::Threads here(threads);
    Eigen::MatrixXd X;
    EXPECT_TRUE(solve_conjugate_gradients(A, Eigen::VectorXd::Ones(A.rows()), X, "test", options).converged);
    return X;
  };
  const Eigen::MatrixXd one = solve(1);
  EXPECT_EQ(solve(2), one);
  EXPECT_EQ(solve(3), one);
}

TEST(Iterative, ConjugateGradientsCanBeCancelled) {
  SparseMatrix A(3, 3);
  A.setIdentity();
  A.coeffRef(1, 1) = 2;
  IterativeOptions options;
  options.preconditioner = Preconditioner::Diagonal;
  Eigen::MatrixXd X;
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(solve_conjugate_gradients(A, Eigen::VectorXd::Ones(3), X, "test", options, stop), Cancelled);
}

TEST(Iterative, GmresSolvesWhereTheMatrixIsNotSymmetric) {
  const SparseMatrix A = random_sparse(70, 70, 2);
  Eigen::MatrixXd X_true = Eigen::MatrixXd::Random(70, 2), X;
  const IterativeReport report = solve_gmres(A, A * X_true, X, "test", kTight);
  EXPECT_TRUE(report.converged);
  EXPECT_LT((X - X_true).norm(), 1e-7);
}

// The oracle is the dense least-squares solution.
TEST(Iterative, LsqrFindsTheLeastSquaresSolution) {
  const SparseMatrix A = random_sparse(90, 40, 3);
  const Eigen::MatrixXd B = Eigen::MatrixXd::Random(90, 2);
  const Eigen::MatrixXd X_true = Eigen::MatrixXd(A).colPivHouseholderQr().solve(B);
  Eigen::MatrixXd X;
  const IterativeReport report = solve_lsqr(A, B, X, "test", kTight);
  EXPECT_TRUE(report.converged);
  EXPECT_LT((X - X_true).norm(), 1e-8);
}

TEST(Iterative, RefusesAToleranceThatNoSolveKeeps) {
  const SparseMatrix A = fixtures::grid_laplacian(2, 1);
  const Eigen::MatrixXd B = Eigen::MatrixXd::Ones(4, 1);
  IterativeOptions options;
  for (const double tolerance : {0.0, 1.0, -1.0, std::nan("")}) {
    options.tolerance = tolerance;
    ASSERT_TRUE(options.problem().has_value()) << tolerance;
    EXPECT_EQ(options.problem()->find("tolerance must be in (0, 1), got "), 0U);
    Eigen::MatrixXd X;
    EXPECT_THROW(solve_conjugate_gradients(A, B, X, "test", options), InvalidInput);
    EXPECT_THROW(solve_gmres(A, B, X, "test", options), InvalidInput);
    EXPECT_THROW(solve_lsqr(A, B, X, "test", options), InvalidInput);
    Eigen::VectorXd x;
    const LinearOperator identity = [](const Eigen::VectorXd& in, Eigen::VectorXd& out) { out = in; };
    EXPECT_THROW(solve_conjugate_gradients(identity, B.col(0), B.col(0), x, "test", options), InvalidInput);
  }
  options = {.max_iterations = -1};
  EXPECT_EQ(options.problem(), "max_iterations must be at least 0, got -1");
  EXPECT_EQ(IterativeOptions().problem(), std::nullopt);
}

TEST(Iterative, SaysWhenItDidNotConverge) {
  const SparseMatrix A = random_sparse(90, 40, 3);
  Eigen::MatrixXd X;
  EXPECT_FALSE(
      solve_lsqr(A, Eigen::MatrixXd::Random(90, 1), X, "test", {.tolerance = 1e-12, .max_iterations = 2})
          .converged);
}

}  // namespace
}  // namespace batten
