#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/scan/bordered_chain_detail.hpp"

namespace batten {
namespace {

constexpr int kBlocks = 5, kBorder = 3, kSize = 9 * kBlocks + kBorder;

// The same residuals as one dense least-squares problem.
TEST(BorderedChain, AgreesWithDenseAlgebra) {
  Random random(1);
  const auto filled = [&](int rows, int columns) {
    Eigen::MatrixXd m(rows, columns);
    for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = random.normal();
    return m;
  };
  BorderedChain<9> chain(kBlocks, kBorder);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(kSize, kSize);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kSize);
  for (int k = 0; k < kBlocks; ++k) {
    for (int i = 0; i < 6; ++i) {
      Eigen::MatrixXd row = Eigen::MatrixXd::Zero(3, kSize);
      const Eigen::Vector3d r = random.normal3();
      row.middleCols(9 * k, 9) = filled(3, 9);
      if (k + 1 < kBlocks) {
        row.middleCols(9 * k + 9, 9) = filled(3, 9);
        row.rightCols(kBorder) = filled(3, kBorder);
        chain.add<3>(k, row.middleCols<9>(9 * k), row.middleCols<9>(9 * k + 9), row.rightCols(kBorder), r);
      } else {
        chain.add<3>(k, row.middleCols<9>(9 * k), r);
      }
      A += row.transpose() * row;
      right -= row.transpose() * r;
    }
  }
  chain.add_border(1, 2.0, 0.5);
  A(9 * kBlocks + 1, 9 * kBlocks + 1) += 2;
  right[9 * kBlocks + 1] -= 1;
  ASSERT_TRUE(chain.solve());
  const Eigen::VectorXd x = A.ldlt().solve(right);
  const Eigen::MatrixXd inverse = A.inverse();
  for (int k = 0; k < kBlocks; ++k) {
    EXPECT_LT((chain.step(k) - x.segment<9>(9 * k)).norm(), 1e-9 * x.norm());
    EXPECT_LT((chain.turn_covariances()[k] - inverse.block<3, 3>(9 * k, 9 * k)).norm(),
              1e-9 * inverse.norm());
  }
  EXPECT_LT((chain.border_step() - x.tail<kBorder>()).norm(), 1e-9 * x.norm());
  EXPECT_LT((chain.border_covariance() - inverse.bottomRightCorner<kBorder, kBorder>()).norm(),
            1e-9 * inverse.norm());
}

TEST(BorderedChain, TellsWhatIsNotPositiveDefinite) {
  BorderedChain<9> chain(2, 1);
  chain.add_border(0, 1, 0);
  EXPECT_FALSE(chain.solve());
}

}  // namespace
}  // namespace batten
