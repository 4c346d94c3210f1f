#include "batten/core/progress.hpp"

#include <string>

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(Progress, IsSilentWithoutACallback) {
  EXPECT_NO_THROW(Progress().report("solve", 0.5));
}

TEST(Progress, PassesStageAndFractionOn) {
  std::string stage;
  double fraction = 0;
  const Progress progress([&](std::string_view s, double f) {
    stage = s;
    fraction = f;
    return true;
  });
  progress.report("solve", 0.25);
  EXPECT_EQ(stage, "solve");
  EXPECT_EQ(fraction, 0.25);
}

TEST(Progress, ThrowsCancelledWhereTheCallbackAsksToStop) {
  const Progress progress([](std::string_view, double fraction) { return fraction < 0.5; });
  EXPECT_NO_THROW(progress.report("solve", 0.4));
  EXPECT_THROW(progress.report("solve", 0.5), Cancelled);
}

}  // namespace
}  // namespace batten
