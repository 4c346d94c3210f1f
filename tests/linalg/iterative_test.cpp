#include "batten/linalg/iterative.hpp"

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

SparseMatrix random_sparse(int rows, int columns, std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < rows; ++i) {
    entries.emplace_back(i, i % columns, 4.0);
    for (int k = 0; k < 3; ++k) entries.emplace_back(i, random.below(columns), random.normal());
  }
  SparseMatrix A(rows, columns);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

const IterativeOptions kTight{.tolerance = 1e-11, .max_iterations = 2000};

TEST(Iterative, ConjugateGradientsSolvesNormalEquations) {
  const SparseMatrix R = random_sparse(80, 60, 1);
  SparseMatrix A = R.transpose() * R;
  Eigen::MatrixXd X_true = Eigen::MatrixXd::Random(60, 2), X;
  const IterativeReport report = solve_conjugate_gradients(A, A * X_true, X, "test", kTight);
  EXPECT_TRUE(report.converged);
  EXPECT_LT((X - X_true).norm(), 1e-7);
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

TEST(Iterative, SaysWhenItDidNotConverge) {
  const SparseMatrix A = random_sparse(90, 40, 3);
  Eigen::MatrixXd X;
  EXPECT_FALSE(
      solve_lsqr(A, Eigen::MatrixXd::Random(90, 1), X, "test", {.tolerance = 1e-12, .max_iterations = 2})
          .converged);
}

}  // namespace
}  // namespace batten
