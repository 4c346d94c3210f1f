#include "batten/mesh/spatial_order.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

// A space-filling curve through n random points of a square has steps of the order of 1/√n; the order of the
// numbers has the mean distance of two random points, 0.52.
TEST(SpatialOrder, VisitsEveryPointOnceAndNeighboursTogether) {
  Random random(3);
  Points points(4000, 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i) points.row(i) << random.uniform(), random.uniform(), 7.0;
  const std::vector<int> order = spatial_order(points);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<int> all(4000);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sorted, all);
  double length = 0;
  for (std::size_t i = 1; i < order.size(); ++i)
    length += (points.row(order[i]) - points.row(order[i - 1])).norm();
  EXPECT_LT(length / 4000, 2.5 / std::sqrt(4000.0));
}

// Points at one place follow their numbers; no points have no order.
TEST(SpatialOrder, TakesCoincidentAndNoPoints) {
  EXPECT_EQ(spatial_order(Points::Constant(3, 3, 1.5)), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(spatial_order(Points(0, 3)).empty());
}

// Cells of 1/1024 of the extent: all points of a block of 2, 4, 8 and 16 cells follow each other, whichever
// the bits of their places.
TEST(SpatialOrder, KeepsBlocksOfCellsTogether) {
  for (const int origin : {0, 512, 992}) {
    Points points(16 * 16 * 16 + 2, 3);
    for (int i = 0; i < 4096; ++i) points.row(i) << origin + i % 16, origin + i / 16 % 16, origin + i / 256;
    points.row(4096).setZero();
    points.row(4097).setConstant(1023);
    std::vector<int> order = spatial_order(points);
    order.erase(std::remove_if(order.begin(), order.end(), [](int i) { return i >= 4096; }), order.end());
    for (const int side : {2, 4, 8}) {
      const int block = side * side * side;
      for (int k = 0; k < 4096; ++k) {
        const Eigen::RowVector3d p = points.row(order[static_cast<size_t>(k)]),
                                 q = points.row(order[static_cast<size_t>(k / block * block)]);
        for (int axis = 0; axis < 3; ++axis)
          ASSERT_EQ(std::floor(p[axis] / side), std::floor(q[axis] / side)) << side << ", " << k;
      }
    }
  }
}

}  // namespace
}  // namespace batten
