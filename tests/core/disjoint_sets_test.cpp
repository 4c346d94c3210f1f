#include "batten/core/disjoint_sets.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

TEST(DisjointSets, StartsWithEveryElementOnItsOwn) {
  DisjointSets none(0);
  EXPECT_EQ(none.n_sets(), 0);
  EXPECT_TRUE(none.labels().empty());
  DisjointSets sets(3);
  EXPECT_EQ(sets.n_sets(), 3);
  EXPECT_EQ(sets.labels(), (std::vector<int>{0, 1, 2}));
}

TEST(DisjointSets, KnowsASetByItsSmallestElement) {
  DisjointSets sets(6);
  EXPECT_TRUE(sets.unite(5, 3));
  EXPECT_TRUE(sets.unite(4, 5));
  EXPECT_FALSE(sets.unite(3, 4));
  EXPECT_EQ(sets.root(5), 3);
  EXPECT_TRUE(sets.unite(1, 4));
  EXPECT_EQ(sets.root(5), 1);
  EXPECT_TRUE(sets.joined(3, 5));
  EXPECT_FALSE(sets.joined(0, 5));
  EXPECT_EQ(sets.n_sets(), 3);
  EXPECT_EQ(sets.labels(), (std::vector<int>{0, 1, 2, 1, 1, 1}));
  EXPECT_EQ(sets.add(), 6);
  EXPECT_EQ(sets.n_sets(), 4);
  EXPECT_EQ(sets.root(6), 6);
}

// The oracle is the transitive closure of the pairs, by relabelling everything at each of them.
TEST(DisjointSets, AgreeWithTheClosureOfRandomPairsInAnyOrder) {
  constexpr int kElements = 200;
  Random random(11);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < 150; ++i)
    pairs.emplace_back(static_cast<int>(random.below(kElements)), static_cast<int>(random.below(kElements)));
  std::vector<int> smallest(kElements);
  for (int i = 0; i < kElements; ++i) smallest[i] = i;
  for (const auto& [a, b] : pairs) {
    const auto [low, high] = std::minmax(smallest[a], smallest[b]);
    const int from = high, to = low;
    std::replace(smallest.begin(), smallest.end(), from, to);
  }
  DisjointSets forward(kElements), backward(kElements);
  for (const auto& [a, b] : pairs) forward.unite(a, b);
  for (auto pair = pairs.rbegin(); pair != pairs.rend(); ++pair) backward.unite(pair->second, pair->first);
  int n_roots = 0;
  for (int i = 0; i < kElements; ++i) {
    EXPECT_EQ(forward.root(i), smallest[i]);
    EXPECT_EQ(backward.root(i), smallest[i]);
    n_roots += smallest[i] == i ? 1 : 0;
  }
  EXPECT_EQ(forward.n_sets(), n_roots);
  EXPECT_EQ(forward.labels(), backward.labels());
}

}  // namespace
}  // namespace batten
