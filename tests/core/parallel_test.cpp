#include "batten/core/parallel.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/progress.hpp"

namespace batten {
namespace {

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const Eigen::Index n : {0, 1, 7, 1000}) {
    std::vector<int> visits(n, 0);
    parallel_for(n, 3, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(n, 1));
  }
}

TEST(ParallelFor, PassesOnAnException) {
  EXPECT_THROW(parallel_for(100, 1,
                            [](Eigen::Index begin, Eigen::Index) {
                              if (begin == 42) throw InvalidInput("forty-two");
                            }),
               InvalidInput);
}

TEST(Progress, CancelsWhereTheCallbackSaysSo) {
  const Progress progress([](std::string_view, double fraction) { return fraction < 0.5; });
  EXPECT_NO_THROW(progress.report("work", 0.1));
  EXPECT_THROW(progress.report("work", 0.9), Cancelled);
  EXPECT_NO_THROW(Progress().report("work", 1));
}

}  // namespace
}  // namespace batten
