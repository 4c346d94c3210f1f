#include "batten/mesh/essential_loops.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

struct Grid {
  Points positions;
  Triangles triangles;
};

/// A torus of radii 1 and `r`, n × m quads; without its first quad where it is to have a border.
Grid torus(double r, int n, int m, bool has_border = false) {
  Grid grid;
  grid.positions.resize(n * m, 3);
  grid.triangles.resize(2 * n * m - (has_border ? 2 : 0), 3);
  Eigen::Index row = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double u = 2 * kPi * i / n, v = 2 * kPi * j / m, R = 1 + r * std::cos(v);
      grid.positions.row(i * m + j) << R * std::cos(u), R * std::sin(u), r * std::sin(v);
      if (has_border && i == 0 && j == 0) continue;
      const int a = i * m + j, b = (i + 1) % n * m + j, c = (i + 1) % n * m + (j + 1) % m,
                d = i * m + (j + 1) % m;
      grid.triangles.row(row++) << a, b, c;
      grid.triangles.row(row++) << a, c, d;
    }
  return grid;
}

// The meridian is the shortest, 2 π r; the loop through the hole is that around its inside, 2 π (1 − r).
TEST(EssentialLoops, OfATorusGoAroundTheTubeAndThroughTheHole) {
  for (const bool has_border : {false, true}) {
    const Grid grid = torus(0.3, 40, 20, has_border);
    const std::vector<EssentialLoop> loops = essential_loops(grid.positions, grid.triangles);
    ASSERT_GE(loops.size(), 2U);
    EXPECT_EQ(loops.front().vertices.size(), 20U);
    EXPECT_NEAR(loops.front().length, 40 * 0.3 * std::sin(kPi / 20), 1e-9);
    EXPECT_TRUE(std::is_sorted(loops.begin(), loops.end(),
                               [](const auto& a, const auto& b) { return a.length < b.length; }));
    double through = 1e9;
    for (const EssentialLoop& loop : loops) {
      double turned = 0, length = 0;  // about z
      for (std::size_t k = 0; k < loop.vertices.size(); ++k) {
        const Eigen::RowVector3d p = grid.positions.row(loop.vertices[k]);
        const Eigen::RowVector3d q = grid.positions.row(loop.vertices[(k + 1) % loop.vertices.size()]);
        turned += std::atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
        length += (q - p).norm();
      }
      EXPECT_NEAR(length, loop.length, 1e-9);
      if (std::abs(turned) > kPi) through = std::min(through, loop.length);
    }
    EXPECT_NEAR(through, 80 * 0.7 * std::sin(kPi / 40), 0.15);
  }
}

TEST(EssentialLoops, AreNotOnSpheresAndDiscs) {
  Grid octahedron;
  octahedron.positions.resize(6, 3);
  octahedron.positions << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  octahedron.triangles.resize(8, 3);
  octahedron.triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  EXPECT_TRUE(essential_loops(octahedron.positions, octahedron.triangles).empty());
  EXPECT_TRUE(essential_loops(octahedron.positions, octahedron.triangles.topRows(4)).empty());
  EXPECT_TRUE(essential_loops(Points(0, 3), Triangles(0, 3)).empty());
  octahedron.triangles(0, 0) = 6;
  EXPECT_THROW(essential_loops(octahedron.positions, octahedron.triangles), InvalidInput);
}

// Two tori, one of them far from the first root.
TEST(EssentialLoops, AreFoundOnEveryComponent) {
  const Grid one = torus(0.3, 24, 12);
  Points positions(2 * one.positions.rows(), 3);
  positions << one.positions, (one.positions.array() * 2).rowwise() + Eigen::RowVector3d(9, 0, 0).array();
  Triangles triangles(2 * one.triangles.rows(), 3);
  triangles << one.triangles, one.triangles.array() + static_cast<int>(one.positions.rows());
  int of_second = 0;
  for (const EssentialLoop& loop : essential_loops(positions, triangles))
    of_second += loop.vertices.front() >= static_cast<int>(one.positions.rows());
  EXPECT_GE(of_second, 2);
}

}  // namespace
}  // namespace batten
