#include "threads.hpp"

#include <algorithm>
#include <tuple>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/scan/block_ldlt_detail.hpp"

namespace batten {
namespace {

/// A sparse symmetric matrix of blocks, positive definite but for its multipliers, with its dense twin.
template <int B>
struct Example {
  Example(int n, int n_ties, std::uint64_t seed) : random(seed), multiplier(n, 0) {
    for (int i = 0; i < n; ++i)
      for (int d = 1; d <= 3 && i + d < n; ++d) joined.emplace_back(i + d, i);
    for (int i = 0; i < n_ties; ++i) {
      const auto a = static_cast<int>(random.below(n)), b = static_cast<int>(random.below(n));
      if (a != b) joined.emplace_back(std::max(a, b), std::min(a, b));
    }
    std::sort(joined.begin(), joined.end());
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    for (int i = 0; i < n / 5; ++i) multiplier[random.below(n)] = 1;
    factor = BlockLdlt<B>(n, joined, multiplier);
    dense.setZero(B * n, B * n);
    fill();
  }

  void fill() {
    factor.clear();
    dense.setZero();
    const auto add = [&](int a, int b, const Eigen::Matrix<double, B, B>& block) {
      factor.add(factor.slot(a, b), block);
      dense.template block<B, B>(B * a, B * b) += block;
      if (a != b) dense.template block<B, B>(B * b, B * a) += block.transpose();
    };
    for (const auto& [a, b] : joined) {
      Eigen::Matrix<double, B, B> block;
      for (int i = 0; i < B * B; ++i) block(i) = random.normal();
      if (random.below(2) == 0)
        add(a, b, block);
      else
        add(b, a, block);
    }
    for (int i = 0; i < factor.size(); ++i)
      add(i, i, (multiplier[i] ? -60.0 : 60.0) * Eigen::Matrix<double, B, B>::Identity());
  }

  Random random;
  std::vector<std::pair<int, int>> joined;
  std::vector<char> multiplier;
  BlockLdlt<B> factor;
  Eigen::MatrixXd dense;
};

template <int B>
void expect_as_dense(int n, int n_ties) {
  Example<B> example(n, n_ties, 7);
  ASSERT_TRUE(example.factor.factorize());
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(example.dense);
  EXPECT_NEAR(example.factor.log_determinant(), lu.matrixLU().diagonal().array().abs().log().sum(), 1e-9);
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(B * n, -1, 2);
  EXPECT_LT((example.factor.solve(right) - lu.solve(right)).norm(), 1e-12);
  const Eigen::MatrixXd inverse = lu.inverse();
  const auto error = [&](int a, int b) {
    return (example.factor.inverse(example.factor.slot(a, b)) - inverse.block<B, B>(B * a, B * b)).norm();
  };
  example.factor.invert();
  for (const auto& [a, b] : example.joined) EXPECT_LT(error(a, b) + error(b, a), 1e-13);
  for (int i = 0; i < n; ++i) EXPECT_LT(error(i, i), 1e-13);
  // The blocks of a few unknowns alone.
  ASSERT_TRUE((example.fill(), example.factor.factorize()));
  const Eigen::MatrixXd other = example.dense.inverse();
  example.factor.invert({0, n / 2});
  for (const int i : {0, n / 2})
    EXPECT_LT((example.factor.inverse(example.factor.slot(i, i)) - other.block<B, B>(B * i, B * i)).norm(),
              1e-13);
}

TEST(BlockLdlt, SolvesAndInvertsAsADenseFactorDoes) {
  expect_as_dense<3>(4, 0);
  expect_as_dense<3>(60, 0);
  expect_as_dense<3>(60, 100);
  expect_as_dense<1>(100, 40);
}

TEST(BlockLdlt, RefusesAPivotOfTheWrongSign) {
  Example<3> example(20, 5, 3);
  example.factor.add(example.factor.slot(11, 11),
                     (example.multiplier[11] ? 200.0 : -200.0) * Eigen::Matrix3d::Identity());
  EXPECT_FALSE(example.factor.factorize());
  example.fill();
  EXPECT_TRUE(example.factor.factorize());
  example.fill();
  example.factor.add(example.factor.slot(3, 2), Eigen::Matrix3d::Constant(std::nan("")));
  EXPECT_FALSE(example.factor.factorize());
}

TEST(BlockLdlt, GivesTheSameBitsForEveryNumberOfThreads) {
  constexpr int n = 6000;
  std::vector<std::pair<int, int>> joined;
  for (int i = 0; i < n; ++i)
    for (int d = 1; d <= 3 && i + d < n; ++d) joined.emplace_back(i + d, i);
  const auto solved = [&](int threads) {
    const test::Threads here(threads);
    BlockLdlt<3> factor(n, joined);
    Random random(4);
    for (const auto& [a, b] : joined)
      factor.add(factor.slot(a, b), random.normal() * Eigen::Matrix3d::Identity());
    for (int i = 0; i < n; ++i) factor.add(factor.slot(i, i), 20 * Eigen::Matrix3d::Identity());
    EXPECT_TRUE(factor.factorize());
    const Eigen::VectorXd x = factor.solve(Eigen::VectorXd::Ones(3 * n));
    factor.invert();
    return std::tuple(factor.log_determinant(), x, factor.inverse(factor.slot(17, 18)));
  };
  const auto one = solved(1);
  for (const int threads : {2, 3}) EXPECT_TRUE(solved(threads) == one);
}

// L Lᵀ is the matrix, whatever the order of elimination.
TEST(BlockLdlt, RootTimesItsTransposeIsTheMatrix) {
  BlockLdlt<1> chain(4, {{1, 0}, {2, 1}, {3, 2}, {3, 0}});
  chain.clear();
  Eigen::Matrix4d dense = Eigen::Matrix4d::Zero();
  for (const auto& [a, b, value] : {std::tuple(0, 0, 4.0),
                                    {1, 1, 5.0},
                                    {2, 2, 6.0},
                                    {3, 3, 7.0},
                                    {1, 0, 1.0},
                                    {2, 1, -2.0},
                                    {3, 2, 0.5},
                                    {3, 0, 1.5}}) {
    chain.add(chain.slot(a, b), BlockLdlt<1>::Block(value));
    dense(a, b) = dense(b, a) = value;
  }
  ASSERT_TRUE(chain.factorize());
  Eigen::Matrix4d root;
  for (int k = 0; k < 4; ++k) root.col(k) = chain.root_times(Eigen::Vector4d::Unit(k));
  EXPECT_LT((root * root.transpose() - dense).norm(), 1e-13);
}

}  // namespace
}  // namespace batten
