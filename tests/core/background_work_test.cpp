#include "batten/core/background_work.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using namespace std::chrono_literals;

// The caller can wait a little, go on waiting, and has what was done when the end was reached.
TEST(BackgroundWork, IsWaitedFor) {
  std::promise<void> may_end;
  bool done = false;
  BackgroundWork work([&] {
    may_end.get_future().wait();
    done = true;
  });
  EXPECT_FALSE(work.wait(1ms));
  may_end.set_value();
  EXPECT_TRUE(work.wait(10s));
  work.finish();
  EXPECT_TRUE(done);
}

TEST(BackgroundWork, ThrowsWhatTheWorkThrew) {
  BackgroundWork work([] { throw SolverFailure("work", 3); });
  EXPECT_TRUE(work.wait(10s));
  EXPECT_THROW(work.finish(), SolverFailure);
}

// Nobody waits for it any more: it goes on with what it owns, which is freed when it is done, and can be
// joined.
TEST(BackgroundWork, GoesOnWhenItIsLeft) {
  const auto owned = std::make_shared<std::atomic<int>>(0);
  std::promise<void> may_end;
  {
    const BackgroundWork work([owned, end = std::make_shared<std::future<void>>(may_end.get_future())] {
      end->wait();
      *owned = 7;
    });
  }
  EXPECT_EQ(*owned, 0);
  may_end.set_value();
  BackgroundWork::join_left();
  EXPECT_EQ(*owned, 7);
  EXPECT_EQ(owned.use_count(), 1);
}

}  // namespace
}  // namespace batten
