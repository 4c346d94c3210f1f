#include <cmath>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/surfacing/tessellation_detail.hpp"

namespace batten::detail {
namespace {

PlaneRegion circle(int n, double radius = 1, bool clockwise = false) {
  PlaneRegion region;
  region.corners.resize(n, 2);
  for (int i = 0; i < n; ++i)
    region.corners.row(i) << radius * std::cos(2 * kPi * i / n), radius * std::sin(2 * kPi * i / n);
  region.loops.emplace_back(n);
  std::iota(region.loops[0].begin(), region.loops[0].end(), 0);
  if (clockwise) std::reverse(region.loops[0].begin(), region.loops[0].end());
  return region;
}

double polygon_area(const PlaneRegion& region) {
  double sum = 0;
  for (const auto& loop : region.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto a = region.corners.row(loop[i]), b = region.corners.row(loop[(i + 1) % loop.size()]);
      sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
  return sum;
}

struct Measured {
  double area = 0, largest = 0, smallest_angle = 4;
};
Measured measure(const Tessellation& t) {
  Measured m;
  for (Eigen::Index f = 0; f < t.triangles.rows(); ++f) {
    const Eigen::RowVector2d p[3] = {t.vertices.row(t.triangles(f, 0)), t.vertices.row(t.triangles(f, 1)),
                                     t.vertices.row(t.triangles(f, 2))};
    const Eigen::RowVector2d u = p[1] - p[0], v = p[2] - p[0];
    const double area = 0.5 * (u.x() * v.y() - u.y() * v.x());
    EXPECT_GT(area, 0) << "triangle " << f << " is folded";
    m.area += area;
    m.largest = std::max(m.largest, area);
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector2d a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
      m.smallest_angle = std::min(m.smallest_angle, std::acos(a.dot(b) / (a.norm() * b.norm())));
    }
  }
  return m;
}

/// Border edges of the triangles, as pairs in their order of walk.
std::set<std::pair<int, int>> border(const Tessellation& t) {
  std::set<std::pair<int, int>> edges;
  const std::vector<int> opposite = opposite_half_edges(t.triangles);
  for (std::size_t h = 0; h < opposite.size(); ++h)
    if (opposite[h] < 0) {
      const auto f = static_cast<Eigen::Index>(h / 3);
      edges.emplace(t.triangles(f, (h + 1) % 3), t.triangles(f, (h + 2) % 3));
    }
  return edges;
}

TEST(Tessellate, CoversAPolygonWithTheWantedTrianglesAndNeverSplitsItsEdges) {
  const int n = 60;
  const PlaneRegion region = circle(n);
  const double h = 2 * std::sin(kPi / n);
  TessellationOptions options;
  options.max_area = h * h / 2;
  const Tessellation t = tessellate(region, options);
  ASSERT_TRUE(t.valid) << t.problem;
  const Measured m = measure(t);
  EXPECT_NEAR(m.area, polygon_area(region), 1e-12);
  // Smoothing evens areas out but does not bound them.
  EXPECT_LT(m.largest, 1.4 * options.max_area);
  EXPECT_GT(m.smallest_angle, radians(25));
  std::set<std::pair<int, int>> expected;
  for (int i = 0; i < n; ++i) expected.emplace(i, (i + 1) % n);
  EXPECT_EQ(border(t), expected);
}

TEST(Tessellate, MeetsTheAngleAndAreaBoundsWithoutSmoothing) {
  const PlaneRegion region = circle(60);
  TessellationOptions options;
  const double h = 2 * std::sin(kPi / 60);
  options.max_area = h * h / 2;
  options.smoothing_rounds = 0;
  const Measured m = measure(tessellate(region, options));
  EXPECT_LE(m.largest, options.max_area * 1.0000001);
  EXPECT_GT(m.smallest_angle, radians(20));
}

TEST(Tessellate, LeavesHolesOpen) {
  PlaneRegion region = circle(48);
  const PlaneRegion hole = circle(20, 0.4, true);
  PlanePoints corners(68, 2);
  corners << region.corners, hole.corners;
  region.corners = corners;
  region.loops.push_back(hole.loops[0]);
  for (int& v : region.loops[1]) v += 48;
  TessellationOptions options;
  options.max_area = 0.01;
  const Tessellation t = tessellate(region, options);
  ASSERT_TRUE(t.valid) << t.problem;
  EXPECT_NEAR(measure(t).area, polygon_area(region), 1e-12);
  EXPECT_EQ(border(t).size(), 68u);
}

TEST(Tessellate, SaysWhyARegionCannotBeFilled) {
  TessellationOptions options;
  options.max_area = 0.1;
  PlaneRegion bow;
  bow.corners.resize(4, 2);
  bow.corners << 0, 0, 1, 1, 1, 0, 0, 1;
  bow.loops = {{0, 1, 2, 3}};
  EXPECT_NE(tessellate(bow, options).problem.find("crosses itself"), std::string::npos);
  EXPECT_NE(tessellate(circle(12, 1, true), options).problem.find("wrong way"), std::string::npos);
  PlaneRegion twice = circle(8);
  twice.corners.row(3) = twice.corners.row(0);
  EXPECT_NE(tessellate(twice, options).problem.find("one point"), std::string::npos);
  PlaneRegion touching;
  touching.corners.resize(5, 2);
  touching.corners << 0, 0, 2, 0, 2, 1, 1, 0, 0, 1;
  touching.loops = {{0, 1, 2, 3, 4}};
  EXPECT_FALSE(tessellate(touching, options).valid);
}

TEST(Tessellate, GivesTheSameTrianglesEveryTime) {
  TessellationOptions options;
  options.max_area = 0.004;
  const Tessellation a = tessellate(circle(50), options), b = tessellate(circle(50), options);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
}

// A curve sampled almost straight: a triangle over three samples in a row would leave one sample out, and the
// patch on the other side might use the same chord.
TEST(Tessellate, CutsNoSampleOffABluntCorner) {
  PlaneRegion region;
  region.corners.resize(7, 2);
  region.corners << 0, 0, 1, -0.001, 1.002, -0.0011, 1.004, -0.001, 2, 0, 2, 1, 0, 1;
  region.loops = {{0, 1, 2, 3, 4, 5, 6}};
  TessellationOptions options;
  options.max_area = 0.5;
  const Tessellation t = tessellate(region, options);
  ASSERT_TRUE(t.valid);
  for (Eigen::Index f = 0; f < t.triangles.rows(); ++f) {
    std::set<int> corners = {t.triangles(f, 0), t.triangles(f, 1), t.triangles(f, 2)};
    EXPECT_NE(corners, (std::set<int>{1, 2, 3}));
  }
}

}  // namespace
}  // namespace batten::detail
