#include "batten/linalg/sparse_cholesky.hpp"

#include "linalg/systems.hpp"

#include <thread>

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using fixtures::backends;
using fixtures::grid_laplacian;

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

/// A function of whatever library is loaded, or null.
template <typename Function>
Function loaded(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
}

// What the calling program has set for itself is its own affair: 1 level of OpenMP, its default, and more.
TEST(SparseCholesky, PutsTheSettingsOfBlasAndOpenMpBack) {
  if (!SparseCholesky::has_cholmod()) GTEST_SKIP() << "built without CHOLMOD";
  const auto blas_threads = loaded<int (*)()>("openblas_get_num_threads");
  const auto set_blas_threads = loaded<void (*)(int)>("openblas_set_num_threads");
  const auto levels = loaded<int (*)()>("omp_get_max_active_levels");
  const auto set_levels = loaded<void (*)(int)>("omp_set_max_active_levels");
  if (blas_threads == nullptr && levels == nullptr) GTEST_SKIP() << "neither OpenBLAS nor OpenMP is loaded";
  const int blas_before = blas_threads != nullptr ? blas_threads() : 0,
            levels_before = levels != nullptr ? levels() : 0;
  if (set_blas_threads != nullptr) set_blas_threads(3);
  const SparseMatrix A = grid_laplacian(20, 0);
  SparseCholesky solver("grid", CholeskyBackend::Cholmod);
  for (const int wanted : {1, 0, 5}) {
    if (set_levels != nullptr) set_levels(wanted);
    solver.factorize(A);
    if (levels != nullptr) {
      EXPECT_EQ(levels(), wanted);
    }
  }
  const auto expect_unchanged = [&] {
    if (blas_threads != nullptr) {
      EXPECT_EQ(blas_threads(), 3);
    }
    if (levels != nullptr) {
      EXPECT_EQ(levels(), 5);
    }
  };
  expect_unchanged();
  solver.solve(Eigen::VectorXd::Ones(400));
  expect_unchanged();
  EXPECT_THROW(solver.factorize(grid_laplacian(4, -5)), SolverFailure);
  expect_unchanged();
  // Two at a time: the last to leave puts back what the first found.
  std::thread other([] {
    SparseCholesky second("grid", CholeskyBackend::Cholmod);
    for (int i = 0; i < 50; ++i) second.factorize(grid_laplacian(20, i));
  });
  for (int i = 0; i < 50; ++i) solver.factorize(grid_laplacian(20, i));
  other.join();
  expect_unchanged();
  if (set_blas_threads != nullptr) set_blas_threads(blas_before);
  if (set_levels != nullptr) set_levels(levels_before);
}

TEST(SparseCholesky, GivesTheSameWhetherOrNotSomebodyListens) {
  if (!SparseCholesky::has_cholmod()) GTEST_SKIP() << "built without CHOLMOD";
  const SparseMatrix A = grid_laplacian(130, 0);
  ASSERT_GE(A.rows(), SparseCholesky::kCholmodFrom);
  SparseCholesky alone("grid"), heard("grid");
  alone.factorize(A);
  heard.factorize(A, Progress([](std::string_view, double) { return true; }));
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(A.rows(), -1, 1);
  EXPECT_EQ(alone.solve(b), heard.solve(b));
}

// CHOLMOD cannot be interrupted; what it still works on after a cancellation must not be touched, and the
// solver can be used again at once. (The first report comes after 50 ms: the system is large enough for
// that.)
TEST(SparseCholesky, CanBeCancelledAndUsedAgain) {
  if (!SparseCholesky::has_cholmod()) GTEST_SKIP() << "built without CHOLMOD";
  SparseCholesky solver("grid");
  for (int run = 0; run < 3; ++run) {
    {
      const SparseMatrix large = grid_laplacian(300, 0.1 * run);
      const Progress stop([](std::string_view, double) { return false; });
      EXPECT_THROW(solver.factorize(large, stop), Cancelled);
      EXPECT_THROW(solver.solve(Eigen::VectorXd::Ones(large.rows())), SolverFailure);
    }
    const SparseMatrix A = grid_laplacian(130, 1);
    solver.factorize(A, Progress([](std::string_view, double) { return true; }));
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(A.rows(), -1, 1);
    EXPECT_LT((solver.solve(A * x) - x).norm(), 1e-9);
  }
}

// The smallest eigenvalue of the grid is 8 sin²(π/42) = 0.0447: a shift below its negative makes A
// indefinite.
TEST(SparseCholesky, TellsWhetherAMatrixIsDefiniteAndGoesOn) {
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("grid", backend);
    EXPECT_FALSE(solver.try_factorize(grid_laplacian(20, -0.05)));
    EXPECT_THROW(solver.solve(Eigen::MatrixXd::Ones(400, 1)), SolverFailure);
    const SparseMatrix A = grid_laplacian(20, -0.04);
    EXPECT_TRUE(solver.try_factorize(A));
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(400, -1, 1);
    EXPECT_LT((solver.solve(A * x) - x).norm(), 1e-10 * x.norm());
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
