#include "batten/mesh/box_tree.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

Box random_box(Random& random, double size) {
  const Eigen::Vector3d centre = random.normal3();
  Eigen::Vector3d half;
  for (int k = 0; k < 3; ++k) half[k] = size * random.uniform();
  return {centre - half, centre + half};
}

/// On each axis on its own, as intervals do.
bool meet_by_axes(const Box& a, const Box& b) {
  for (int k = 0; k < 3; ++k)
    if (std::max(a.low[k], b.low[k]) > std::min(a.high[k], b.high[k])) return false;
  return true;
}

TEST(BoxTree, FindsEveryBoxThatMeetsAndNoOther) {
  Random random(17);
  for (const int n : {0, 1, 4, 5, 300}) {
    std::vector<Box> boxes;
    for (int i = 0; i < n; ++i) boxes.push_back(random_box(random, 0.2));
    const BoxTree tree(boxes);
    for (int q = 0; q < 200; ++q) {
      const Box query = random_box(random, q % 2 == 0 ? 0.1 : 1);
      std::vector<int> found, expected;
      tree.query(query, [&](int i) {
        found.push_back(i);
        return true;
      });
      for (int i = 0; i < n; ++i)
        if (meet_by_axes(boxes[static_cast<size_t>(i)], query)) expected.push_back(i);
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected) << n << ", " << q;
    }
  }
}

// A box holds its border: boxes that touch in a corner meet, also where one has no extent.
TEST(Box, MeetsWhatTouchesIt) {
  const Box unit{{0, 0, 0}, {1, 1, 1}};
  EXPECT_TRUE(unit.meets({{1, 1, 1}, {2, 2, 2}}));
  EXPECT_TRUE(unit.meets({{0, 0.5, 1}, {0, 0.5, 1}}));
  for (int axis = 0; axis < 3; ++axis) {
    Box beside{{0.4, 0.4, 0.4}, {0.6, 0.6, 0.6}};
    beside.low[axis] = beside.high[axis] = 1 + 1e-15;
    EXPECT_FALSE(unit.meets(beside));
    EXPECT_FALSE(beside.meets(unit));
    beside.low[axis] = beside.high[axis] = -1e-15;
    EXPECT_FALSE(unit.meets(beside));
  }
  Box both = unit;
  both.include({{-1, 0.5, 2}, {0.5, 3, 2}});
  EXPECT_EQ(both.low, Eigen::Vector3d(-1, 0, 0));
  EXPECT_EQ(both.high, Eigen::Vector3d(1, 3, 2));
}

// All boxes alike: every one is found, and a visit that has seen enough ends the search.
TEST(BoxTree, EndsWhereTheVisitSaysSo) {
  const std::vector<Box> boxes(100, Box{{0, 0, 0}, {1, 1, 1}});
  const BoxTree tree(boxes);
  int seen = 0;
  tree.query(boxes[0], [&](int) { return ++seen < 7; });
  EXPECT_EQ(seen, 7);
  seen = 0;
  tree.query(boxes[0], [&](int) { return ++seen > 0; });
  EXPECT_EQ(seen, 100);
}

}  // namespace
}  // namespace batten
