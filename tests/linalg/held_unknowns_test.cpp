#include "batten/linalg/held_unknowns.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

constexpr int kUnknowns = 60;

/// A random sparse symmetric matrix that is positive definite because its diagonal dominates.
SparseMatrix random_matrix(Random& random) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < kUnknowns; ++i) {
    entries.emplace_back(i, i, 20.0);
    for (int k = 0; k < 3; ++k) {
      const auto j = static_cast<int>(random.below(kUnknowns));
      const double value = random.uniform(-1, 1);
      entries.emplace_back(i, j, value);
      entries.emplace_back(j, i, value);
    }
  }
  SparseMatrix A(kUnknowns, kUnknowns);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

std::vector<char> random_choice(Random& random) {
  std::vector<char> held(kUnknowns);
  for (char& h : held) h = random.uniform(0, 1) < 0.3;
  held.front() = 1;
  held.back() = 0;
  return held;
}

Eigen::MatrixXd random_columns(Random& random, int columns) {
  return Eigen::MatrixXd::NullaryExpr(kUnknowns, columns, [&] { return random.normal(); });
}

TEST(HeldUnknowns, NumbersBothKindsInTheirOrder) {
  const HeldUnknowns split(std::vector<char>{0, 1, 0, 0, 1});
  EXPECT_EQ(split.size(), 5);
  EXPECT_EQ(split.free(), (std::vector<int>{0, 2, 3}));
  EXPECT_EQ(split.held(), (std::vector<int>{1, 4}));
  EXPECT_EQ(split.free_index(), (std::vector<int>{0, -1, 1, 2, -1}));
  EXPECT_EQ(split.held_index(), (std::vector<int>{-1, 0, -1, -1, 1}));
  EXPECT_EQ(HeldUnknowns::all_but({1, 0, 1, 1, 0}).free(), split.free());
}

TEST(HeldUnknowns, TakesTheBlocksOfAMatrixAndTheRowsOfAnArray) {
  Random random(1);
  const SparseMatrix A = random_matrix(random);
  const HeldUnknowns split(random_choice(random));
  const Eigen::MatrixXd dense = A, X = random_columns(random, 2);
  const Eigen::MatrixXd inner = split.free_block(A), lower = split.free_block(A, true),
                        coupling = split.coupling(A), outer = split.held_block(A);
  for (Eigen::Index i = 0; i < split.n_held(); ++i)
    for (Eigen::Index j = 0; j < split.n_held(); ++j)
      EXPECT_EQ(outer(i, j),
                dense(split.held()[static_cast<std::size_t>(i)], split.held()[static_cast<std::size_t>(j)]));
  for (Eigen::Index i = 0; i < split.n_free(); ++i) {
    const int row = split.free()[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < split.n_free(); ++j) {
      EXPECT_EQ(inner(i, j), dense(row, split.free()[static_cast<std::size_t>(j)]));
      EXPECT_EQ(lower(i, j), j <= i ? inner(i, j) : 0);
    }
    for (Eigen::Index j = 0; j < split.n_held(); ++j)
      EXPECT_EQ(coupling(i, j), dense(row, split.held()[static_cast<std::size_t>(j)]));
    EXPECT_EQ(split.free_rows(X).row(i), X.row(row));
  }
  Eigen::MatrixXd Y = X;
  split.add_to_free_rows(split.free_rows(X), Y);
  EXPECT_EQ(split.free_rows(Y), 2 * split.free_rows(X));
  EXPECT_EQ(split.held_rows(Y), split.held_rows(X));
}

// The free rows of A x equal those of b, the held rows of x the given values: for one factor, many held
// values and many columns, and for the next matrix as well.
TEST(HeldSolver, SatisfiesTheFreeRowsAndKeepsTheHeldValues) {
  Random random(2);
  const HeldUnknowns split(random_choice(random));
  HeldSolver solver("test", split);
  for (int matrix = 0; matrix < 2; ++matrix) {
    const SparseMatrix A = random_matrix(random);
    solver.factorize(A);
    for (const int columns : {1, 3, 11}) {
      const Eigen::MatrixXd b = random_columns(random, columns), values = random_columns(random, columns);
      const Eigen::MatrixXd x = solver.solve(b, values);
      EXPECT_LT((split.free_rows(A * x) - split.free_rows(b)).norm(), 1e-12 * b.norm());
      EXPECT_EQ(split.held_rows(x), split.held_rows(values));
      const Eigen::MatrixXd y = solver.solve_homogeneous(values);
      EXPECT_LT(split.free_rows(A * y).norm(), 1e-12 * values.norm());
    }
  }
}

TEST(HeldSolver, TakesAMatrixInItsTwoParts) {
  Random random(3);
  const SparseMatrix A = random_matrix(random);
  const HeldUnknowns split(random_choice(random));
  HeldSolver whole("test", split), parts("test", split);
  whole.factorize(A);
  parts.factorize(split.free_block(A, true), split.coupling(A));
  const Eigen::MatrixXd b = random_columns(random, 2), values = random_columns(random, 2);
  EXPECT_EQ(whole.solve(b, values), parts.solve(b, values));
}

TEST(HeldSolver, ReturnsTheValuesWhereAllIsHeldAndSolvesWhereNothingIs) {
  Random random(4);
  const SparseMatrix A = random_matrix(random);
  const Eigen::MatrixXd b = random_columns(random, 2), values = random_columns(random, 2);
  HeldSolver all("test", HeldUnknowns(std::vector<char>(kUnknowns, 1)));
  all.factorize(A);
  EXPECT_EQ(all.solve(b, values), values);
  HeldSolver none("test", HeldUnknowns(std::vector<char>(kUnknowns, 0)));
  none.factorize(A);
  EXPECT_LT((A * none.solve(b, values) - b).norm(), 1e-12 * b.norm());
}

TEST(HeldSolver, RefusesWhatIsNotPositiveDefiniteOrNotFactorised) {
  Random random(5);
  SparseMatrix A = random_matrix(random);
  const HeldUnknowns split(random_choice(random));
  HeldSolver solver("test", split);
  const Eigen::MatrixXd values = random_columns(random, 1);
  EXPECT_THROW(solver.solve_homogeneous(values), SolverFailure);
  EXPECT_THROW(solver.factorize(SparseMatrix(-A)), SolverFailure);
  EXPECT_THROW(solver.solve_homogeneous(values), SolverFailure);
  // Only the free block has to be definite.
  const int held = split.held().front();
  A.coeffRef(held, held) = -1e6;
  EXPECT_NO_THROW(solver.factorize(A));
}

}  // namespace
}  // namespace batten
