#include "batten/mesh/self_intersections.hpp"

#include "mesh/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/mesh/predicates.hpp"

namespace batten {
namespace {

TEST(SelfIntersections, FindCrossingTouchingOverlappingAndEqualTriangles) {
  const auto pairs_of = [](const Points& second, const Triangles& triangles) {
    Points all(3 + second.rows(), 3);
    all << 0, 0, 0, 4, 0, 0, 0, 4, 0, second;
    return self_intersections(all, triangles).size();
  };
  const Triangles apart = (Triangles(2, 3) << 0, 1, 2, 3, 4, 5).finished();
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, -1, 1, 1, 1, 5, 5, 1).finished(), apart), 1u);  // pierced
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 1, 1, 1, 5, 5, 1).finished(), apart),
            1u);  // touched by a corner
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 1e-300, 1, 1, 1, 5, 5, 1).finished(), apart), 0u);  // just not
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 9, 9, 0, 9, 8, 0).finished(), apart),
            1u);  // overlap in a plane
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 1.5, 1, 0, 1, 1.5, 0).finished(), apart), 1u);  // inside it
  EXPECT_EQ(pairs_of((Points(3, 3) << 3, 3, 0, 9, 9, 0, 9, 8, 0).finished(), apart), 0u);      // beside it
  EXPECT_EQ(pairs_of((Points(3, 3) << 0, 0, 0, 4, 0, 0, 0, 4, 0).finished(), apart), 1u);  // equal, unwelded
  EXPECT_EQ(pairs_of((Points(3, 3) << 4, 0, 0, 0, 0, 0, 1, -3, 0).finished(), apart),
            0u);  // neighbours, unwelded
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 2, 1, 0, 3, 1, 0).finished(), apart), 0u);  // without area
  // sharing vertex 0: one beside, one that pierces
  const Triangles vertex = (Triangles(2, 3) << 0, 1, 2, 0, 3, 4).finished();
  EXPECT_EQ(pairs_of((Points(2, 3) << -4, 0, 0, 0, -4, 0).finished(), vertex), 0u);
  EXPECT_EQ(pairs_of((Points(2, 3) << 1, 1, 1, 1, 1, -1).finished(), vertex), 1u);
  // sharing the edge 0–1: a roof is fine, a fold onto the other is not
  const Triangles edge = (Triangles(2, 3) << 0, 1, 2, 1, 0, 3).finished();
  EXPECT_EQ(pairs_of((Points(1, 3) << 1, 1, 1e-12).finished(), edge), 0u);
  EXPECT_EQ(pairs_of((Points(1, 3) << 1, 1, 0).finished(), edge), 1u);
  EXPECT_EQ(pairs_of((Points(1, 3) << 1, -1, 0).finished(), edge), 0u);
}

// Two spheres that overlap cross; apart they do not; the surface of one alone never does.
TEST(SelfIntersections, OfTwoSpheresDependOnTheirDistance) {
  const Shape one = fixtures::sphere(12);
  EXPECT_TRUE(self_intersections(one.positions, one.triangles).empty());
  for (const double distance : {1.5, 2.1}) {
    const Shape other = fixtures::sphere(12, 1, {distance, 0.01, 0.02});
    Points all(one.positions.rows() * 2, 3);
    all << one.positions, other.positions;
    Triangles both(one.triangles.rows() * 2, 3);
    both << one.triangles, other.triangles.array() + static_cast<int>(one.positions.rows());
    EXPECT_EQ(self_intersections(all, both).empty(), distance > 2) << distance;
    if (distance < 2) {
      EXPECT_EQ(self_intersections(all, both, 5).size(), 5u);
    }
  }
}

// A second implementation: all pairs, without the hierarchy of boxes, on random triangles.
TEST(SelfIntersections, AgreeWithTheTestOfAllPairs) {
  Random random(12);
  Points points(300, 3);
  for (int v = 0; v < 300; ++v) points.row(v) = random.normal3().transpose();
  Triangles triangles(100, 3);
  for (int f = 0; f < 100; ++f) triangles.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  const auto p = [&](int f, int k) { return Eigen::Vector3d(points.row(triangles(f, k % 3))); };
  std::vector<std::pair<int, int>> expected;
  for (int f = 0; f < 100; ++f)
    for (int g = f + 1; g < 100; ++g) {
      bool meet = false;
      for (int k = 0; k < 3; ++k)
        meet = meet || segment_meets_triangle(p(f, k), p(f, k + 1), p(g, 0), p(g, 1), p(g, 2)) ||
               segment_meets_triangle(p(g, k), p(g, k + 1), p(f, 0), p(f, 1), p(f, 2));
      if (meet) expected.emplace_back(f, g);
    }
  EXPECT_GT(expected.size(), 50u);
  EXPECT_EQ(self_intersections(points, triangles, 100000), expected);
}

// One triangle pierced by ten others: of all its pairs the first ones, and no more than asked for.
TEST(SelfIntersections, ListsTheFirstPairsOnly) {
  Points points(33, 3);
  Triangles triangles(11, 3);
  points.topRows(3) << 0, 0, 0, 100, 0, 0, 0, 100, 0;
  for (int f = 1; f <= 10; ++f) points.middleRows(3 * f, 3) << 2 * f, 1, -1, 2 * f + 1, 1, -1, 2 * f, 1, 1;
  for (int f = 0; f <= 10; ++f) triangles.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  EXPECT_EQ(self_intersections(points, triangles).size(), 10u);
  EXPECT_EQ(self_intersections(points, triangles, 3),
            (std::vector<std::pair<int, int>>{{0, 1}, {0, 2}, {0, 3}}));
}

}  // namespace
}  // namespace batten
