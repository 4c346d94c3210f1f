#include "batten/core/stage_times.hpp"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace batten {
namespace {

using Stages = std::vector<std::pair<std::string, double>>;

// Powers of two add without rounding, so that sums are exact.
TEST(StageTimes, AddsUpWhatRunsAgainAndKeepsTheOrderOfTheFirstRuns) {
  StageTimes times;
  times.add("solve", 1);
  times.add("assembly", 0.5);
  times.add("solve", 2);
  EXPECT_EQ(times.stages(), (Stages{{"solve", 3}, {"assembly", 0.5}}));
  EXPECT_EQ(times.total(), 3.5);
}

TEST(StageTimes, TakesOverTheStagesOfAnother) {
  StageTimes times, part;
  times.add("solve", 1);
  part.add("assembly", 4);
  part.add("solve", 8);
  times.add(part);
  EXPECT_EQ(times.stages(), (Stages{{"solve", 9}, {"assembly", 4}}));
  EXPECT_EQ(StageTimes().total(), 0);
}

TEST(StageTimes, AScopeAddsItsOwnLife) {
  StageTimes times;
  {
    const ScopedStage outer(times, "outer");
    const ScopedStage inner(times, "inner");
    EXPECT_TRUE(times.stages().empty());  // nothing before the scope ends
  }
  ASSERT_EQ(times.stages().size(), 2U);
  EXPECT_EQ(times.stages()[0].first, "inner");  // destroyed first
  EXPECT_EQ(times.stages()[1].first, "outer");
  EXPECT_GE(times.stages()[0].second, 0);
  EXPECT_GE(times.stages()[1].second, times.stages()[0].second);  // it encloses the other
}

}  // namespace
}  // namespace batten
