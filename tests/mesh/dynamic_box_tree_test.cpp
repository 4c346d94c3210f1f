#include "batten/mesh/dynamic_box_tree.hpp"

#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;
using Boxes = std::map<int, Box>;

/// Boxes of sizes over four orders of magnitude; some flat, some points, some equal to others.
Box random_box(Random& random) {
  Vector3d low = random.normal3();
  Vector3d size = std::pow(10.0, random.uniform(-3, 1)) * random.normal3().cwiseAbs();
  if (random.uniform() < 0.3) size(static_cast<int>(random.below(3))) = 0;
  if (random.uniform() < 0.1) size.setZero();
  if (random.uniform() < 0.2) low = low.array().round();
  return {low, low + size};
}

std::vector<int> meeting_one_by_one(const Boxes& boxes, const Box& box) {
  std::vector<int> found;
  for (const auto& [item, own] : boxes)
    if (own.meets(box)) found.push_back(item);
  return found;
}

double distance(const Box& box, const Vector3d& point) {
  return (point - point.cwiseMax(box.low).cwiseMin(box.high)).norm();
}

void expect_same(const DynamicBoxTree& tree, const Boxes& boxes, Random& random) {
  ASSERT_EQ(tree.empty(), boxes.empty());
  const Box box = random_box(random);
  EXPECT_EQ(tree.meeting(box), meeting_one_by_one(boxes, box));
  if (boxes.empty()) return;
  Box all = boxes.begin()->second;
  for (const auto& [item, own] : boxes) all.include(own);
  EXPECT_EQ(tree.bounds().low, all.low);
  EXPECT_EQ(tree.bounds().high, all.high);
  const Vector3d point = random.normal3();
  double least = std::numeric_limits<double>::infinity(), found = least;
  for (const auto& [item, own] : boxes) least = std::min(least, distance(own, point));
  tree.visit_nearest([&](const Box& own) { return distance(own, point); },
                     [&](int item) { return found = std::min(found, distance(boxes.at(item), point)); });
  EXPECT_EQ(found, least);
}

// A second implementation asks every box.
TEST(DynamicBoxTree, FindsWhatAskingEveryBoxFinds) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed);
    DynamicBoxTree tree;
    Boxes boxes;
    for (int step = 0; step < 2000; ++step) {
      // Grows and shrinks in turns, down to nothing.
      const bool grows = step / 400 % 2 == 0;
      const int item = static_cast<int>(random.below(300));
      if (random.uniform() < (grows ? 0.7 : 0.1)) {
        tree.set(item, boxes[item] = random_box(random));
      } else {
        tree.remove(item);
        boxes.erase(item);
      }
      if (step % 500 == 499) {
        std::vector<std::pair<int, Box>> items(boxes.begin(), boxes.end());
        tree.assign(items);
      }
      expect_same(tree, boxes, random);
    }
    while (!boxes.empty()) {
      tree.remove(boxes.begin()->first);
      boxes.erase(boxes.begin());
      expect_same(tree, boxes, random);
    }
  }
}

/// How many boxes of the tree a search for one point asks.
int n_asked(const DynamicBoxTree& tree, const Vector3d& point) {
  int n = 0;
  tree.visit_nearest(
      [&](const Box& box) {
        ++n;
        return distance(box, point);
      },
      [](int) { return 0.0; });
  return n;
}

// Boxes in a row, coming from one end to the other: the worst order for a tree that is not balanced. A search
// in a balanced one asks two boxes on each of about 1.44 log2 n levels, and few more where boxes meet.
TEST(DynamicBoxTree, SearchesStayShortWhateverTheOrder) {
  constexpr int n = 20000;
  DynamicBoxTree in_order, there_and_back, built;
  std::vector<std::pair<int, Box>> items;
  for (int i = 0; i < n; ++i) items.emplace_back(i, Box{Vector3d(i, 0, 0), Vector3d(i + 0.9, 1, 0)});
  for (const auto& [item, box] : items) in_order.set(item, box);
  for (const auto& [item, box] : items) there_and_back.set(item, box);
  for (int i = n / 2; i < n; ++i) there_and_back.remove(i);
  for (int i = n - 1; i >= n / 2; --i) there_and_back.set(i, items[static_cast<size_t>(i)].second);
  built.assign(items);
  for (const DynamicBoxTree* tree : {&in_order, &there_and_back, &built})
    for (const int i : {0, 1, n / 3, n / 2, n - 1})
      EXPECT_LE(n_asked(*tree, Vector3d(i + 0.5, 0.5, 0)), 60) << i;
}

// All boxes alike: no order among them helps, so the balance is all there is.
TEST(DynamicBoxTree, TakesManyEqualBoxes) {
  DynamicBoxTree tree;
  const Box box{Vector3d::Zero(), Vector3d::Ones()};
  for (int i = 0; i < 5000; ++i) tree.set(i, box);
  EXPECT_EQ(tree.meeting({Vector3d::Ones(), 2 * Vector3d::Ones()}).size(), 5000u);
  EXPECT_TRUE(tree.meeting({1.1 * Vector3d::Ones(), 2 * Vector3d::Ones()}).empty());
  for (int i = 0; i < 4999; ++i) tree.remove(i);
  EXPECT_EQ(tree.meeting(box), std::vector<int>{4999});
}

}  // namespace
}  // namespace batten
