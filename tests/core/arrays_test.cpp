#include "batten/core/arrays.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace batten {
namespace {

// Files and other languages hold x y z x y z …: that memory is an array of points as it is, and the other way
// round.
TEST(Arrays, AreTheNumbersOfTheirRowsOneAfterTheOther) {
  const std::vector<double> numbers{1, 2, 3, 4, 5, 6};
  const Points points = Eigen::Map<const Points>(numbers.data(), 2, 3);
  EXPECT_EQ(points.row(1), Eigen::RowVector3d(4, 5, 6));
  EXPECT_EQ(std::vector<double>(points.data(), points.data() + points.size()), numbers);
  const Triangles triangles = (Triangles(2, 3) << 0, 1, 2, 2, 1, 3).finished();
  EXPECT_EQ(std::vector<int>(triangles.data(), triangles.data() + triangles.size()),
            (std::vector<int>{0, 1, 2, 2, 1, 3}));
}

}  // namespace
}  // namespace batten
