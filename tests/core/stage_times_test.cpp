#include "batten/core/stage_times.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(StageTimes, AddUpByStageInTheOrderOfTheFirstRun) {
  StageTimes times;
  EXPECT_EQ(times.total(), 0);
  times.add("read", 1);
  times.add("solve", 2);
  times.add("read", 0.5);
  ASSERT_EQ(times.stages().size(), 2U);
  EXPECT_EQ(times.stages()[0], std::make_pair(std::string("read"), 1.5));
  EXPECT_EQ(times.stages()[1], std::make_pair(std::string("solve"), 2.0));
  StageTimes others;
  others.add("write", 4);
  others.add("solve", 1);
  times.add(others);
  EXPECT_EQ(times.total(), 8.5);
  EXPECT_EQ(times.stages()[1].second, 3);
  EXPECT_EQ(times.stages()[2].first, "write");
}

TEST(ScopedStage, AddsItsLifeWhenItEndsAndNotBefore) {
  StageTimes times;
  {
    const ScopedStage stage(times, "work");
    EXPECT_TRUE(times.stages().empty());
  }
  ASSERT_EQ(times.stages().size(), 1U);
  EXPECT_EQ(times.stages()[0].first, "work");
  EXPECT_GE(times.stages()[0].second, 0);
}

}  // namespace
}  // namespace batten
