// What a factor refuses, which backend it takes, and how matrices may be stored.
#include "linalg/systems.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {
namespace {

using fixtures::backends;
using fixtures::grid_laplacian;

TEST(SparseCholesky, RefusesRightSidesOfAnotherSizeOrNotFinite) {
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("grid", backend);
    solver.factorize(grid_laplacian(4, 0));
    EXPECT_EQ(solver.unknowns(), 16);
    EXPECT_THROW(solver.solve(Eigen::VectorXd::Ones(15)), SolverFailure);
    EXPECT_THROW(solver.solve(Eigen::VectorXd::Ones(17)), SolverFailure);
    Eigen::VectorXd b = Eigen::VectorXd::Ones(16);
    b[7] = std::nan("");
    EXPECT_THROW(solver.solve(b), SolverFailure);
    EXPECT_NO_THROW(solver.solve(Eigen::VectorXd::Ones(16)));  // the factor is as before
  }
}

// A matrix under construction has gaps between its columns; a factor must not read them.
TEST(SparseCholesky, TakesMatricesThatAreNotCompressed) {
  for (const CholeskyBackend backend : backends()) {
    SparseMatrix A(30, 30);
    A.reserve(Eigen::VectorXi::Constant(30, 8));
    for (int i = 0; i < 30; ++i) A.insert(i, i) = 4;
    for (int i = 1; i < 30; ++i) A.insert(i, i - 1) = -1;
    ASSERT_FALSE(A.isCompressed());
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    SparseCholesky loose("loose", backend), dense("compressed", backend);
    loose.factorize(A);
    dense.factorize(compressed);
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(30, 1, 2);
    EXPECT_EQ(loose.solve(b), dense.solve(b));
  }
}

// Right-hand sides are substituted several at a time; each must come out as if it were alone, however many
// there are: to the bit by our own substitution, to rounding by CHOLMOD's blocks.
TEST(SparseCholesky, SolvesAnyNumberOfRightHandSidesAlike) {
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("grid", backend);
    solver.factorize(grid_laplacian(7, 0.5));
    for (Eigen::Index columns = 1; columns <= 17; ++columns) {
      const Eigen::MatrixXd B = Eigen::MatrixXd::Random(49, columns), X = solver.solve(B);
      ASSERT_EQ(X.cols(), columns);
      for (Eigen::Index c = 0; c < columns; ++c) {
        const Eigen::VectorXd alone = solver.solve(B.col(c));
        if (backend == CholeskyBackend::Cholmod)
          EXPECT_LT((X.col(c) - alone).norm(), 1e-14 * alone.norm()) << columns << ", " << c;
        else
          EXPECT_EQ(X.col(c), alone) << columns << ", " << c;
      }
    }
  }
}

// The same number of entries in every column, elsewhere: the ordering of the first must not serve the second.
TEST(SparseCholesky, TellsPatternsApartThatDifferInTheirRowsAlone) {
  const auto matrix = [](int distance) {
    SparseMatrix A(40, 40);
    for (int i = 0; i < 40; ++i) A.insert(i, i) = 4;
    for (int i = 0; i < 8; ++i) A.insert(i + distance, i) = A.insert(i, i + distance) = -1;
    A.makeCompressed();
    return SparseMatrix(A.triangularView<Eigen::Lower>());
  };
  for (const CholeskyBackend backend : backends()) {
    SparseCholesky solver("pattern", backend);
    for (const int distance : {9, 30, 17}) {
      const SparseMatrix A = matrix(distance);
      solver.factorize(A);
      const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(40, 1, 2);
      EXPECT_LT((solver.solve(A.selfadjointView<Eigen::Lower>() * x) - x).norm(), 1e-13) << distance;
    }
  }
}

TEST(SparseCholesky, AutoTakesCholmodForLargeSystemsOnly) {
  const auto chosen = [](Eigen::Index n) {
    SparseMatrix A(n, n);
    A.setIdentity();
    SparseCholesky solver("identity");
    solver.factorize(A);
    return solver.backend();
  };
  const CholeskyBackend large =
      SparseCholesky::has_cholmod() ? CholeskyBackend::Cholmod : CholeskyBackend::Eigen;
  EXPECT_EQ(chosen(SparseCholesky::kCholmodFrom), large);
  EXPECT_EQ(chosen(SparseCholesky::kCholmodFrom - 1), CholeskyBackend::Eigen);
}

}  // namespace
}  // namespace batten
