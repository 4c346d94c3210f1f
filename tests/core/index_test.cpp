#include "batten/core/index.hpp"

#include <limits>
#include <type_traits>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(At, IsTheSameNumberWithoutASign) {
  static_assert(std::is_same_v<decltype(at(1)), std::size_t>);
  static_assert(std::is_same_v<decltype(at(Eigen::Index{1})), std::size_t>);
  EXPECT_EQ(at(0), 0U);
  EXPECT_EQ(at(std::numeric_limits<int>::max()), std::size_t{2147483647});
  EXPECT_EQ(at(std::numeric_limits<Eigen::Index>::max()), std::size_t{9223372036854775807});
}

#ifndef NDEBUG
TEST(AtDeathTest, RefusesNoneInDebugBuilds) {
  EXPECT_DEATH(at(-1), "i >= 0");
}
#endif

}  // namespace
}  // namespace batten
