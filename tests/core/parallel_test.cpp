#include "batten/core/parallel.hpp"

#include "threads.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
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

/// The threads that a loop of many chunks runs on, when no thread can take all of them.
std::set<std::thread::id> threads_of_loop() {
  std::set<std::thread::id> ids;
  std::mutex mutex;
  std::atomic<int> waiting{thread_count()};
  parallel_for(thread_count(), 1, [&](Eigen::Index, Eigen::Index) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      ids.insert(std::this_thread::get_id());
    }
    --waiting;
    while (waiting > 0) std::this_thread::yield();  // until every chunk has a thread of its own
  });
  return ids;
}

TEST(ParallelFor, RunsOnTheThreadsAskedFor) {
  for (const int n : {1, 2, 5}) {
    const test::Threads threads(n);
    EXPECT_EQ(thread_count(), n);
    EXPECT_EQ(threads_of_loop().size(), static_cast<std::size_t>(n));
  }
  EXPECT_GE(thread_count(), 1);
  EXPECT_THROW(set_thread_count(-1), InvalidInput);
}

TEST(ParallelFor, KeepsLoopsInsideOfLoopsOnTheirThread) {
  const test::Threads threads(4);
  parallel_for(8, 1, [&](Eigen::Index, Eigen::Index) {
    const std::thread::id own = std::this_thread::get_id();
    parallel_for(100, 1, [&](Eigen::Index, Eigen::Index) { EXPECT_EQ(std::this_thread::get_id(), own); });
  });
  EXPECT_EQ(threads_of_loop().size(), 4U);  // and the next loop is parallel again
}

// Chunks are taken in their order, so the first that fails has always begun before a later one fails.
TEST(ParallelFor, PassesOnTheFirstOfSeveralExceptions) {
  const test::Threads threads(3);
  for (int run = 0; run < 50; ++run) {
    std::string message;
    try {
      parallel_for(100, 1, [](Eigen::Index begin, Eigen::Index) {
        if (begin >= 10) throw InvalidInput(std::to_string(begin));
      });
    } catch (const InvalidInput& error) {
      message = error.what();
    }
    EXPECT_EQ(message, "10");
  }
}

TEST(ParallelFor, ReportsFromTheCallingThreadAndStops) {
  const test::Threads threads(3);
  const std::thread::id caller = std::this_thread::get_id();
  std::vector<double> fractions;
  std::atomic<bool> stopped{false};
  const Progress progress([&](std::string_view, double fraction) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    fractions.push_back(fraction);
    stopped = fractions.size() == 5;
    return !stopped;
  });
  std::atomic<int> chunks{0};
  const auto loop = [&] {
    parallel_for(
        1000, 1,
        [&](Eigen::Index, Eigen::Index) {
          ++chunks;
          // The other threads must not finish all of it before the calling one has come to its fifth report.
          while (std::this_thread::get_id() != caller && !stopped) std::this_thread::yield();
        },
        progress);
  };
  EXPECT_THROW(loop(), Cancelled);
  EXPECT_EQ(fractions.size(), 5U);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_LT(chunks, 1000);
}

// The rounding of a sum depends on its order: it must be the same for any number of threads.
TEST(ParallelSum, IsTheSameToTheLastBitOnAnyNumberOfThreads) {
  const auto sum = [](int n) {
    const test::Threads threads(n);
    return parallel_sum(100003, 1000, [](Eigen::Index begin, Eigen::Index end) {
      double part = 0;
      for (Eigen::Index i = begin; i < end; ++i) part += 1.0 / static_cast<double>(i + 1);
      return part;
    });
  };
  const double one = sum(1);
  EXPECT_NEAR(one, 12.0901, 1e-3);  // ln 100003 + Euler's constant
  EXPECT_EQ(sum(2), one);
  EXPECT_EQ(sum(7), one);
  EXPECT_EQ(parallel_sum(0, 10, [](Eigen::Index, Eigen::Index) { return 1.0; }), 0);
}

TEST(Progress, PassesPartsOnAsPartsOfTheWhole) {
  std::vector<std::pair<std::string, double>> seen;
  const Progress progress([&](std::string_view stage, double fraction) {
    seen.emplace_back(stage, fraction);
    return true;
  });
  const Progress half = progress.part("second half", 0.5, 1);
  half.report("anything", 0);
  half.part("inside", 0, 0.5).report("anything", 1);
  const std::vector<std::pair<std::string, double>> expected = {{"second half", 0.5}, {"second half", 0.75}};
  EXPECT_EQ(seen, expected);
  EXPECT_TRUE(Progress().part("silent", 0, 1).is_silent());
  EXPECT_FALSE(half.is_silent());
}

TEST(Progress, CancelsWhereTheCallbackSaysSo) {
  const Progress progress([](std::string_view, double fraction) { return fraction < 0.5; });
  EXPECT_NO_THROW(progress.report("work", 0.1));
  EXPECT_THROW(progress.report("work", 0.9), Cancelled);
  EXPECT_NO_THROW(Progress().report("work", 1));
}

}  // namespace
}  // namespace batten
