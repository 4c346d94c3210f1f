// What all iterative solvers promise at the edges: warm starts, several columns, limits, numbers that are not
// finite.
#include "linalg/systems.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/linalg/iterative.hpp"

namespace batten {
namespace {

using fixtures::kTight;
using fixtures::random_sparse;

/// The three solvers by one name: all keep the same promises.
enum class Solver { ConjugateGradients, Gmres, Lsqr };
constexpr Solver kSolvers[] = {Solver::ConjugateGradients, Solver::Gmres, Solver::Lsqr};

IterativeReport solve_by(Solver solver, const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                         const IterativeOptions& options) {
  switch (solver) {
    case Solver::ConjugateGradients:
      return solve_conjugate_gradients(A, B, X, "test", options);
    case Solver::Gmres:
      return solve_gmres(A, B, X, "test", options);
    case Solver::Lsqr:
      return solve_lsqr(A, B, X, "test", options);
  }
  return {};
}

/// Symmetric, positive definite by its diagonal, and with rows so far apart that no incomplete factor is
/// exact.
SparseMatrix scattered(int n) {
  const SparseMatrix R = random_sparse(n, n, 4);
  SparseMatrix identity(n, n);
  identity.setIdentity();
  return SparseMatrix(R.transpose() * R) + 0.1 * identity;
}

// The residual of the report is that of the solution, worked out again here.
TEST(Iterative, ReportsTheResidualWhereItDidNotConverge) {
  const SparseMatrix A = scattered(400);
  const Eigen::MatrixXd B = Eigen::MatrixXd::Random(400, 1);
  for (const Solver solver : kSolvers) {
    Eigen::MatrixXd X;
    const IterativeReport report = solve_by(solver, A, B, X, {.tolerance = 1e-14, .max_iterations = 1});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, 1);
    const Eigen::MatrixXd r = B - A * X;
    const double residual = solver == Solver::Lsqr ? (A.transpose() * r).norm() / (A.transpose() * B).norm()
                                                   : r.norm() / B.norm();
    EXPECT_NEAR(report.residual, residual, 1e-9 * residual);
    EXPECT_GT(residual, 1e-13);
  }
}

// 40 unknowns take about 40 steps: more than a handful, fewer than the 90 that max_iterations = 0 stands for.
TEST(Iterative, AllowsTwiceTheUnknownsByDefault) {
  const SparseMatrix A = random_sparse(90, 40, 3);
  Eigen::MatrixXd X;
  const IterativeReport report =
      solve_lsqr(A, Eigen::MatrixXd::Random(90, 1), X, "test", {.tolerance = 1e-10, .max_iterations = 0});
  EXPECT_TRUE(report.converged);
  EXPECT_GT(report.iterations, 10);
  EXPECT_LE(report.iterations, 90);
}

// Of digits that no double has there is no end: the limit alone ends the search, and it is not below twice
// the unknowns.
TEST(Iterative, DoesNotStopBeforeTwiceTheUnknowns) {
  Eigen::MatrixXd X;
  const IterativeReport report = solve_lsqr(random_sparse(90, 40, 3), Eigen::MatrixXd::Random(90, 1), X,
                                            "test", {.tolerance = 1e-300, .max_iterations = 0});
  EXPECT_FALSE(report.converged);
  EXPECT_GE(report.iterations, 80);
}

// The unit of the right-hand side is no matter of the solver: powers of two scale every number on the way
// without rounding, so the steps are the same and the solution is scaled to the bit.
TEST(Iterative, DoesNotDependOnTheUnit) {
  const SparseMatrix A = scattered(60);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(60);
  for (const Solver solver : kSolvers) {
    Eigen::MatrixXd X;
    const IterativeReport expected = solve_by(solver, A, b, X, kTight);
    for (const double scale : {0x1p-60, 0x1p60}) {
      Eigen::MatrixXd scaled;
      const IterativeReport report = solve_by(solver, A, scale * b, scaled, kTight);
      EXPECT_EQ(report.iterations, expected.iterations) << static_cast<int>(solver);
      EXPECT_EQ(report.converged, expected.converged);
      EXPECT_EQ(scaled, scale * X) << static_cast<int>(solver);
    }
  }
}

// Three columns: one begins at its solution, one is zero, one has everything to do. Each is solved, and the
// report speaks of the slowest, in whichever order they come.
TEST(Iterative, StartsWhereItIsToldAndReportsTheSlowestColumn) {
  const SparseMatrix A = scattered(60);
  const Eigen::VectorXd x = Eigen::VectorXd::Random(60);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(60);
  for (const Solver solver : kSolvers) {
    Eigen::MatrixXd alone(60, 1);
    alone.col(0).setZero();
    const int slowest = solve_by(solver, A, A * x, alone, kTight).iterations;
    EXPECT_GT(slowest, 2);
    for (const bool hard_first : {true, false}) {
      Eigen::MatrixXd B(60, 3), X(60, 3), expected(60, 3);
      B << zero, zero, A * x;
      X << zero, zero, zero;
      expected << zero, zero, x;
      B.col(1) = A * (2 * x);
      X.col(1) = expected.col(1) = 2 * x;
      if (hard_first) {
        B.col(0).swap(B.col(2));
        X.col(0).swap(X.col(2));
        expected.col(0).swap(expected.col(2));
      }
      const IterativeReport report = solve_by(solver, A, B, X, kTight);
      EXPECT_TRUE(report.converged);
      EXPECT_EQ(report.iterations, slowest);
      EXPECT_LT((X - expected).norm(), 1e-7);
      X = expected;  // all at their solutions: nothing to do
      EXPECT_LE(solve_by(solver, A, B, X, kTight).iterations, 1);
      EXPECT_LT((X - expected).norm(), 1e-7);
    }
  }
}

// One column that cannot converge makes the whole not converged, also when an easy one follows.
TEST(Iterative, OneColumnThatFailsIsReported) {
  const SparseMatrix A = scattered(400);
  const Eigen::VectorXd x = Eigen::VectorXd::Random(400);
  for (const Solver solver : kSolvers) {
    Eigen::MatrixXd B(400, 2), X = Eigen::MatrixXd::Zero(400, 2);
    B << A * x, A * x;
    X.col(1) = x;
    EXPECT_FALSE(solve_by(solver, A, B, X, {.tolerance = 1e-14, .max_iterations = 1}).converged);
  }
}

// Each column on its own, and the report speaks of the worst, wherever it stands.
TEST(Iterative, WithADiagonalTheWorstColumnIsReportedWhereverItStands) {
  const SparseMatrix A = scattered(400);
  for (const Eigen::Index hard : {0, 1}) {
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(400, 2), X;
    B.col(hard) = Eigen::VectorXd::Random(400);
    const IterativeReport report = solve_conjugate_gradients(
        A, B, X, "test",
        {.tolerance = 1e-14, .max_iterations = 3, .preconditioner = Preconditioner::Diagonal});
    EXPECT_FALSE(report.converged) << hard;
    EXPECT_EQ(report.iterations, 3);
    // The residual is that of the norm in which it is measured, √(rᵀ D⁻¹ r) over √(bᵀ D⁻¹ b).
    const Eigen::VectorXd D = A.diagonal(), r = B.col(hard) - A * X.col(hard);
    const double residual =
        std::sqrt(r.cwiseAbs2().cwiseQuotient(D).sum() / B.col(hard).cwiseAbs2().cwiseQuotient(D).sum());
    EXPECT_NEAR(report.residual, residual, 1e-9 * residual);
  }
}

TEST(SolveQuality, CountsWhatDidNotConvergeAndKeepsTheLargestResidual) {
  SolveQuality some, all;
  some.add({.iterations = 4, .residual = 0.25, .converged = true});
  EXPECT_EQ(some.unconverged, 0);
  EXPECT_EQ(some.residual, 0.25);
  some.add({.iterations = 9, .residual = 0.125, .converged = false});
  EXPECT_EQ(some.unconverged, 1);
  EXPECT_EQ(some.residual, 0.25);
  all.add({.iterations = 1, .residual = 0.5, .converged = false});
  all.add(some);
  EXPECT_EQ(all.unconverged, 2);
  EXPECT_EQ(all.residual, 0.5);
}

TEST(Iterative, RefusesNumbersThatAreNotFinite) {
  SparseMatrix A = scattered(20);
  Eigen::MatrixXd B = Eigen::MatrixXd::Ones(20, 1);
  B(3) = std::nan("");
  for (const Solver solver : kSolvers) {
    Eigen::MatrixXd X;
    EXPECT_THROW(solve_by(solver, A, B, X, kTight), SolverFailure);
  }
}

// From a start that is right to six digits the other five cost less than all eleven; nothing asks for digits
// that are not there.
TEST(Iterative, AGoodStartSavesIterations) {
  const SparseMatrix A = scattered(200);
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(200, 1), b = A * x;
  for (const Solver solver : kSolvers) {
    Eigen::MatrixXd cold = Eigen::MatrixXd::Zero(200, 1), warm = x + 1e-6 * Eigen::MatrixXd::Random(200, 1);
    const IterativeReport from_zero = solve_by(solver, A, b, cold, kTight);
    const IterativeReport from_near = solve_by(solver, A, b, warm, kTight);
    EXPECT_TRUE(from_zero.converged);
    EXPECT_TRUE(from_near.converged);
    EXPECT_LT(from_near.iterations, from_zero.iterations);
  }
}

}  // namespace
}  // namespace batten
