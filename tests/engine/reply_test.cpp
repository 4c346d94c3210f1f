#include "batten/engine/reply.hpp"

#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "batten/engine/reply_detail.hpp"

namespace batten::detail {
namespace {

TEST(Reply, SubtractsTheOriginBeforePrecisionIsLost) {
  // A millimetre a thousand kilometres away is nothing in single precision, and all of it beside the origin.
  Points points(1, 3);
  points << 1e6 + 0.001, 5, -2;
  Draft draft;
  draft.add_points("positions", points, Eigen::RowVector3d(1e6, 0, 0));
  ASSERT_EQ(draft.arrays.size(), 1U);
  EXPECT_EQ(draft.arrays[0].columns, 3);
  EXPECT_EQ(draft.arrays[0].type, ElementType::Float32);
  std::vector<float> values(3);
  ASSERT_EQ(draft.arrays[0].bytes.size(), 12U);
  std::memcpy(values.data(), draft.arrays[0].bytes.data(), 12);
  EXPECT_NEAR(values[0], 0.001F, 1e-7F);
  EXPECT_EQ(values[1], 5.0F);
  EXPECT_EQ(values[2], -2.0F);
}

TEST(Reply, HasNoWordForWhatIsNotFinite) {
  EXPECT_EQ(json_of(std::numeric_limits<double>::quiet_NaN()).dump(), "null");
  EXPECT_EQ(json_of(std::numeric_limits<double>::infinity()).dump(), "null");
  EXPECT_EQ(json_of(0.5).dump(), "0.5");
}

}  // namespace
}  // namespace batten::detail
