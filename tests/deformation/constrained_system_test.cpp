#include "deformation/tube.hpp"

#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/deformation/constrained_system_detail.hpp"
#include "batten/deformation/handle_responses_detail.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten::detail {
namespace {

constexpr double kBending = 0.7;

/// A tube with both ends constrained, and its matrix as a dense one.
class ConstrainedTube : public testing::Test {
 protected:
  ConstrainedTube() {
    n_ = tube_.positions.rows();
    K_ = cotangent_stiffness(tube_.triangles, edge_lengths(tube_.positions, tube_.triangles), n_);
    inverse_mass_ =
        lumped_mass(tube_.triangles, edge_lengths(tube_.positions, tube_.triangles), n_).cwiseInverse();
    T_ = 0.3 * K_;
    const Eigen::MatrixXd K(K_);
    matrix_ = kBending * K * inverse_mass_.asDiagonal() * K + Eigen::MatrixXd(T_);
    forces_ = Points::Random(n_, 3);
    values_ = Points::Random(static_cast<Eigen::Index>(tube_.ends.size()), 3);
  }

  ConstrainedSystem system(double soft_weight) const {
    ConstrainedSystem made(tube_.ends, n_, soft_weight);
    made.choose_unknowns(std::vector<char>(static_cast<std::size_t>(n_), 1));
    made.factorize(K_, inverse_mass_, kBending, T_, {});
    return made;
  }

  fixtures::Tube tube_ = fixtures::bumpy_tube(12, 4, 0.1, 0.2);
  Eigen::Index n_ = 0;
  SparseMatrix K_, T_;
  Eigen::VectorXd inverse_mass_;
  Eigen::MatrixXd matrix_;
  Points forces_, values_;
};

TEST_F(ConstrainedTube, SolvesTheRowsOfFreeVerticesAndHoldsTheOthers) {
  const Points X = system(0).solve(forces_, values_, forces_);
  Eigen::MatrixXd residual = matrix_ * X - forces_;
  for (std::size_t c = 0; c < tube_.ends.size(); ++c) {
    EXPECT_EQ(X.row(tube_.ends[c]), values_.row(static_cast<Eigen::Index>(c)));
    residual.row(tube_.ends[c]).setZero();
  }
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-9 * matrix_.cwiseAbs().maxCoeff());
}

// (A + s S) X = B + s S C with S the constrained rows and s the weight times the mean diagonal entry.
TEST_F(ConstrainedTube, SoftConstraintsAddTheirPull) {
  constexpr double kWeight = 2;
  const Points X = system(kWeight).solve(forces_, values_, forces_);
  const double pull = kWeight * matrix_.diagonal().mean();
  Eigen::MatrixXd residual = matrix_ * X - forces_;
  for (std::size_t c = 0; c < tube_.ends.size(); ++c)
    residual.row(tube_.ends[c]) += pull * (X.row(tube_.ends[c]) - values_.row(static_cast<Eigen::Index>(c)));
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-9 * matrix_.cwiseAbs().maxCoeff());
}

TEST_F(ConstrainedTube, AVertexWithoutTrianglesStaysOutside) {
  ConstrainedSystem system(tube_.ends, n_, 0);
  std::vector<char> used(static_cast<std::size_t>(n_), 1);
  const int idle = static_cast<int>(n_ / 2);
  used[static_cast<std::size_t>(idle)] = 0;
  system.choose_unknowns(used);
  system.factorize(K_, inverse_mass_, kBending, T_, {});
  const Points outside = Points::Random(n_, 3);
  EXPECT_EQ(system.solve(forces_, values_, outside).row(idle), outside.row(idle));
}

TEST_F(ConstrainedTube, RefusesVerticesOutOfRangeAndTwice) {
  EXPECT_THROW(ConstrainedSystem({0, static_cast<int>(n_)}, n_, 0), InvalidInput);
  EXPECT_THROW(ConstrainedSystem({-1}, n_, 0), InvalidInput);
  EXPECT_THROW(ConstrainedSystem({3, 4, 3}, n_, 0), InvalidInput);
}

// An affine move of one end and another one of the other end: the sum of two responses is the solution.
TEST_F(ConstrainedTube, ResponsesToAffineMovesAreTheSolution) {
  const ConstrainedSystem made = system(0);
  const HandleResponses responses(made, tube_.positions, tube_.triangles, 5);
  Eigen::Matrix3d first, second;
  first << 0.1, 0.2, -0.1, 0, 0.3, 0.1, -0.2, 0.1, 0;
  second << -0.1, 0, 0.2, 0.1, 0.1, 0, 0, -0.3, 0.2;
  Points moves(values_.rows(), 3);
  for (std::size_t c = 0; c < tube_.ends.size(); ++c) {
    const Eigen::RowVector3d p = tube_.positions.row(tube_.ends[c]);
    const bool low = p.z() < 2;
    moves.row(static_cast<Eigen::Index>(c)) =
        p * (low ? first : second) + Eigen::RowVector3d(0.5, low ? -0.2 : 0, 1);
  }
  Points answer;
  ASSERT_TRUE(responses.respond(moves, answer));
  const Points zero = Points::Zero(n_, 3);
  const Points solved = tube_.positions + made.solve(zero, moves, zero);
  EXPECT_LT((answer - solved).cwiseAbs().maxCoeff(), 1e-9);

  moves.row(0).x() += 1e-6;  // no longer affine
  EXPECT_FALSE(responses.respond(moves, answer));
}

// Single vertices apart from one another are regions of their own; more than eight are not worth it.
TEST_F(ConstrainedTube, ManyRegionsAreLeftToTheSystem) {
  for (const int n_regions : {8, 9}) {
    std::vector<int> apart;
    for (int k = 0; k < n_regions; ++k) apart.push_back(24 * (k / 2) + 6 * (k % 2));
    ConstrainedSystem made(apart, n_, 0);
    made.choose_unknowns(std::vector<char>(static_cast<std::size_t>(n_), 1));
    made.factorize(K_, inverse_mass_, kBending, T_, {});
    const HandleResponses responses(made, tube_.positions, tube_.triangles, 5);
    Points answer;
    EXPECT_EQ(responses.respond(Points::Random(n_regions, 3), answer), n_regions == 8);
  }
}

}  // namespace
}  // namespace batten::detail
