#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/strokes/candidate_orders_detail.hpp"

namespace batten::detail {
namespace {

std::vector<Eigen::Vector3d> fan(int k, double height = 0) {
  std::vector<Eigen::Vector3d> tangents;
  for (int i = 0; i < k; ++i)
    tangents.push_back(
        Eigen::Vector3d(std::cos(2 * kPi * i / k), std::sin(2 * kPi * i / k), height).normalized());
  return tangents;
}

TEST(CandidateOrders, HoldEveryOrderWithItsMirrorImage) {
  EXPECT_TRUE(candidate_orders({}, {}).empty());
  std::size_t n_orders = 1;  // (k − 1)!
  for (int k = 1; k <= 6; ++k) {
    if (k > 1) n_orders *= static_cast<std::size_t>(k - 1);
    const std::vector<NodeOrder> orders = candidate_orders(fan(k, 0.3), {});
    EXPECT_EQ(orders.size(), n_orders);
    for (std::size_t o = 0; o < orders.size(); ++o) {
      const NodeOrder& mirrored = orders[static_cast<std::size_t>(orders[o].mirrored)];
      EXPECT_EQ(mirrored.mirrored, static_cast<int>(o));
      EXPECT_EQ(mirrored.left, orders[o].right);
      EXPECT_NEAR(mirrored.cost, orders[o].cost, 1e-12);
    }
  }
}

// In a plane the sectors of the order that one sees turn once; exchanging two neighbours of four makes two
// sectors of 90 and two of 180 degrees: half a turn more, at 1/π a radian.
TEST(CandidateOrders, CostWhatTheirSectorsTurn) {
  for (const NodeOrder& order : candidate_orders(fan(4), {})) {
    const bool seen = order.left[0] == 1 && order.left[1] == 2 && order.left[2] == 3;
    const bool from_below = order.left[0] == 3 && order.left[3] == 2 && order.left[2] == 1;
    EXPECT_NEAR(order.cost, seen || from_below ? 0 : 1, 1e-12);
  }
}

TEST(CandidateOrders, NothingLiesBetweenTwoBorders) {
  const std::vector<NodeOrder> orders = candidate_orders(fan(4), {0, 1});
  EXPECT_EQ(orders.size(), 4U);  // of six
  for (const NodeOrder& order : orders) EXPECT_TRUE(order.left[0] == 1 || order.left[1] == 0);
}

// Beyond seven half-edges only likely orders are tried: the one that is seen from above is the cheapest of
// them.
TEST(CandidateOrders, OfManyCurvesIncludeTheOneThatIsSeen) {
  const std::vector<NodeOrder> orders = candidate_orders(fan(11, 0.4), {});
  EXPECT_LT(orders.size(), 2000U);
  int n_best = 0;
  for (const NodeOrder& order : orders) {
    if (order.cost > 1e-9) continue;
    ++n_best;
    EXPECT_TRUE(order.left[0] == 1 || order.right[0] == 1);
  }
  EXPECT_EQ(n_best, 2);  // and its mirror image
}

}  // namespace
}  // namespace batten::detail
