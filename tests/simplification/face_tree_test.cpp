#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/simplification/face_tree_detail.hpp"

namespace batten::simplification {
namespace {

using Eigen::Vector3d;
using Triangle = FaceTree::Triangle;

// Random pairs that share no or one corner, against the exact test of the room mesh.
TEST(FaceTree, TrianglesTouchAsTheExactTestSays) {
  Random random(3);
  int touching[2] = {0, 0}, apart[2] = {0, 0};
  for (int trial = 0; trial < 6000; ++trial) {
    const int shared = trial % 2;
    Points positions(6 - shared, 3);
    for (Eigen::Index v = 0; v < positions.rows(); ++v) positions.row(v) = random.normal3();
    Triangles triangles(2, 3);
    triangles.row(0) << 0, 1, 2;
    if (shared == 0) triangles.row(1) << 3, 4, 5;
    if (shared == 1) triangles.row(1) << 0, 3, 4;
    Triangle t[2];
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 3; ++k) {
        t[i].corner[k] = triangles(i, k);
        t[i].point[k] = positions.row(triangles(i, k));
      }
    const bool expected = !self_intersections(positions, triangles).empty();
    ASSERT_EQ(triangles_touch(t[0], t[1]), expected) << "pair " << trial;
    ASSERT_EQ(triangles_touch(t[1], t[0]), expected) << "pair " << trial;
    ++(expected ? touching : apart)[shared];
  }
  for (int shared = 0; shared < 2; ++shared) {
    EXPECT_GT(touching[shared], 100);
    EXPECT_GT(apart[shared], 100);
  }
}

// In one plane: side by side, overlapping, and one folded onto its neighbour.
TEST(FaceTree, KnowsTrianglesInOnePlane) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(1, 1, 0), e(0.2, 0.2, 0), f(-1, 0, 0), g(0, -1, 0);
  const Triangle t{{0, 1, 2}, {a, b, c}};
  EXPECT_FALSE(triangles_touch(t, {{1, 3, 2}, {b, d, c}}));  // across the common edge
  EXPECT_TRUE(triangles_touch(t, {{2, 1, 4}, {c, b, e}}));   // folded back over it
  EXPECT_FALSE(triangles_touch(t, {{0, 5, 6}, {a, f, g}}));  // opposite at the common corner
  EXPECT_TRUE(triangles_touch(t, {{0, 3, 4}, {a, d, e + Vector3d(0, 0.3, 0)}}));  // inside at the corner
  EXPECT_FALSE(triangles_touch(t, {{7, 8, 9}, {d, d + b, d + c}}));
  EXPECT_TRUE(triangles_touch(t, {{7, 8, 9}, {e, e + b, e + c}}));
}

// A pyramid on a square, pushed through a plate above it: seen by the query, until it stays below.
TEST(FaceTree, SeesAStarThatWouldPassThroughAnotherSheet) {
  Points positions(8, 3);
  positions << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 0, -5, -5, 1, 5, -5, 1, 0, 5, 1;
  Triangles triangles(5, 3);
  triangles << 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 5, 6, 7;
  const HalfedgeMesh mesh(positions, triangles);
  FaceTree tree(mesh);
  const auto star = [&](double height) {
    std::vector<Triangle> faces;
    for (int f = 0; f < 4; ++f)
      faces.push_back(
          {{triangles(f, 0), triangles(f, 1), 4},
           {positions.row(triangles(f, 0)), positions.row(triangles(f, 1)), Vector3d(0, 0, height)}});
    return faces;
  };
  EXPECT_FALSE(tree.intersects(star(0.9), {0, 1, 2, 3}));
  EXPECT_TRUE(tree.intersects(star(1.1), {0, 1, 2, 3}));
}

}  // namespace
}  // namespace batten::simplification
