#include <cmath>

#include <gtest/gtest.h>

#include "batten/mesh/quality.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/surfacing/relaxation_detail.hpp"

namespace batten {
namespace {

/// A flat grid of n × n squares whose rows crowd towards y = 0; its outline counts as the network.
struct CrowdedGrid {
  Points X, N;
  Triangles T;
  std::vector<char> outline;
};
CrowdedGrid crowded_grid(int n) {
  CrowdedGrid grid;
  const auto vertex = [n](int i, int j) { return j * (n + 1) + i; };
  grid.X.resize((n + 1) * (n + 1), 3);
  grid.N.resize(grid.X.rows(), 3);
  grid.T.resize(2 * n * n, 3);
  grid.outline.assign(static_cast<std::size_t>(grid.X.rows()), 0);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double s = static_cast<double>(j) / n;
      grid.X.row(vertex(i, j)) << static_cast<double>(i) / n, s < 1 && i > 0 && i < n ? std::pow(s, 3) : s, 0;
      grid.N.row(vertex(i, j)) << 0, 0, 1;
      grid.outline[static_cast<std::size_t>(vertex(i, j))] = i == 0 || j == 0 || i == n || j == n;
      if (i == n || j == n) continue;
      grid.T.row(2 * (j * n + i)) << vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1);
      grid.T.row(2 * (j * n + i) + 1) << vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1);
    }
  return grid;
}

// A flat square stays flat and covered once, its outline stays, and the needles beside it are gone.
TEST(RelaxTriangles, EvensOutNeedlesAndKeepsCurves) {
  CrowdedGrid grid = crowded_grid(8);
  ASSERT_GT(detail::count_needles(grid.X, grid.T, grid.outline), 0);
  const Points before = grid.X;
  ASSERT_TRUE(detail::relax_triangles(grid.X, grid.N, grid.T, grid.outline));
  EXPECT_EQ(detail::count_needles(grid.X, grid.T, grid.outline), 0);
  EXPECT_NO_THROW(opposite_half_edges(grid.T));
  EXPECT_TRUE(folded_triangles(grid.X, grid.T, grid.N).empty());
  double area = 0;
  for (Eigen::Index f = 0; f < grid.T.rows(); ++f) {
    const Eigen::RowVector3d a = grid.X.row(grid.T(f, 0)), b = grid.X.row(grid.T(f, 1)),
                             c = grid.X.row(grid.T(f, 2));
    area += 0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
  }
  EXPECT_NEAR(area, 1, 1e-12);
  for (Eigen::Index v = 0; v < before.rows(); ++v)
    if (grid.outline[static_cast<std::size_t>(v)]) {
      EXPECT_EQ(grid.X.row(v), before.row(v));
    }
}

TEST(RelaxTriangles, LeavesGoodTrianglesAlone) {
  CrowdedGrid grid = crowded_grid(2);  // one inner vertex, at a height of 1/8: angles of 14° are needles
  grid.X(4, 1) = 0.5;
  const Points before = grid.X;
  const Triangles triangles = grid.T;
  EXPECT_FALSE(detail::relax_triangles(grid.X, grid.N, grid.T, grid.outline));
  EXPECT_EQ(grid.X, before);
  EXPECT_EQ(grid.T, triangles);
}

}  // namespace
}  // namespace batten
