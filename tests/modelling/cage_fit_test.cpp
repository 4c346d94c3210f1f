#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/modelling/cage_fit_detail.hpp"
#include "batten/subdivision/limit_stencils.hpp"

namespace batten {
namespace {

/// A wavy sheet of n × n quads.
ControlCage sheet(int n) {
  ControlCage cage;
  cage.mesh.positions.resize((n + 1) * (n + 1), 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      cage.mesh.positions.row(i * (n + 1) + j) << i, j, std::sin(1.3 * i) * std::cos(0.9 * j);
  cage.mesh.offsets = {0};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int v = i * (n + 1) + j;
      for (const int corner : {v, v + n + 1, v + n + 2, v + 1}) cage.mesh.corners.push_back(corner);
      cage.mesh.offsets.push_back(static_cast<int>(cage.mesh.corners.size()));
    }
  return cage;
}

// The oracle are the limit stencils, applied to what came out.
TEST(FitLimit, TakesTheLimitSurfaceThroughEveryExactVertexAndSaysSo) {
  ControlCage cage = sheet(7);
  const Points target = cage.mesh.positions;
  const std::vector<char> all(static_cast<size_t>(target.rows()), 1);
  const IterativeReport report = detail::fit_limit(cage, target, all, all);
  EXPECT_TRUE(report.converged);
  EXPECT_GT(report.iterations, 0);
  EXPECT_LT(report.residual, 1e-12);
  EXPECT_LT((limit_stencils(cage) * cage.mesh.positions - target).rowwise().norm().maxCoeff(), 1e-10);
  EXPECT_GT((cage.mesh.positions - target).rowwise().norm().maxCoeff(), 0.01);
}

TEST(FitLimit, LeavesVerticesThatAreNotFreeWhereTheyAre) {
  ControlCage cage = sheet(5);
  const Points target = cage.mesh.positions;
  std::vector<char> free(static_cast<size_t>(target.rows()), 1);
  free[0] = free[7] = 0;
  detail::fit_limit(cage, target, free, std::vector<char>(free.size(), 1));
  EXPECT_EQ(cage.mesh.positions.row(0), target.row(0));
  EXPECT_EQ(cage.mesh.positions.row(7), target.row(7));
  ControlCage held = sheet(5);
  const IterativeReport nothing =
      detail::fit_limit(held, target, std::vector<char>(free.size(), 0), std::vector<char>(free.size(), 1));
  EXPECT_TRUE(nothing.converged);
  EXPECT_EQ(held.mesh.positions, target);
}

TEST(FitLimit, ThrowsWhereTheTargetIsNoNumber) {
  ControlCage cage = sheet(3);
  Points target = cage.mesh.positions;
  target(5, 1) = std::numeric_limits<double>::quiet_NaN();
  const std::vector<char> all(static_cast<size_t>(target.rows()), 1);
  EXPECT_THROW(detail::fit_limit(cage, target, all, all), SolverFailure);
}

}  // namespace
}  // namespace batten
