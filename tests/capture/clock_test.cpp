#include "batten/capture/clock.hpp"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten::test {
namespace {

struct Arrivals {
  std::vector<std::int64_t> device, arrival, truth;
};

/// A device that is `ppm` fast and sends every 10 ms; bytes take 3 ms and then wait for bursts of `burst_us`.
Arrivals bursts(double ppm, std::int64_t burst_us, int n) {
  Arrivals a;
  Random random(3);
  for (int i = 0; i < n; ++i) {
    const std::int64_t taken = 5000000 + std::int64_t{10000} * i;
    std::int64_t arrival = taken + 3000;
    arrival += burst_us - arrival % burst_us;
    a.truth.push_back(taken);
    a.device.push_back(std::llround(static_cast<double>(taken) * (1 + 1e-6 * ppm)) + 777);
    a.arrival.push_back(arrival);
  }
  return a;
}

// The fastest delivery takes 3 ms, which nobody can know; all times are later by it, and by no more than the
// millisecond that bursts of 25 ms and samples of 10 ms leave between their nearest meetings.
TEST(MapClock, FollowsTheFastestDeliveriesThroughBursts) {
  const Arrivals a = bursts(0, 25000, 3000);
  const ClockMapping mapping = map_clock(a.device, a.arrival);
  EXPECT_TRUE(mapping.jumps.empty());
  for (std::size_t i = 0; i < a.truth.size(); ++i) {
    EXPECT_GE(mapping.host_us[i] - a.truth[i], 2999);
    EXPECT_LE(mapping.host_us[i] - a.truth[i], 8001);
  }
}

TEST(MapClock, FindsTheRateOfTheDevice) {
  const Arrivals a = bursts(300, 20000, 6000);
  const ClockMapping mapping = map_clock(a.device, a.arrival);
  EXPECT_NEAR(mapping.rate, 1 / (1 + 300e-6), 1e-5);
  const std::int64_t first = mapping.host_us.front() - a.truth.front();
  const std::int64_t last = mapping.host_us.back() - a.truth.back();
  EXPECT_LT(std::abs(first - last), 1000);  // 300 ppm of a minute would be 18 ms
}

TEST(MapClock, BeginsAnewWhereTheClockOfTheDeviceWasSet) {
  for (const std::int64_t jump : {std::int64_t{-300000000}, std::int64_t{4000000}}) {
    Arrivals a = bursts(0, 20000, 1000);
    for (std::size_t i = 400; i < a.device.size(); ++i) a.device[i] += jump;
    const ClockMapping mapping = map_clock(a.device, a.arrival);
    ASSERT_EQ(mapping.jumps, std::vector<std::size_t>{400});
    for (std::size_t i = 0; i < a.truth.size(); ++i)
      EXPECT_LT(std::abs(mapping.host_us[i] - a.truth[i]), 25000);
  }
}

// A network that holds everything back for two seconds is no clock that was set.
TEST(MapClock, TakesALateStretchForLate) {
  Arrivals a = bursts(0, 20000, 1000);
  for (std::size_t i = 300; i < 340; ++i) a.arrival[i] = a.arrival[340];
  const ClockMapping mapping = map_clock(a.device, a.arrival);
  EXPECT_TRUE(mapping.jumps.empty());
  EXPECT_LT(std::abs(mapping.host_us[300] - a.truth[300]), 25000);
}

TEST(Unwrapper, CountsOnOverTheWrapAndBack) {
  Unwrapper unwrap;
  EXPECT_EQ(unwrap(4294967290U), 4294967290);
  EXPECT_EQ(unwrap(4), 4294967300);
  EXPECT_EQ(unwrap(4294967295U), 4294967295);
}

TEST(LiveClock, AgreesWithTheWholeRecordingAfterSomeSamples) {
  const Arrivals a = bursts(0, 20000, 1000);
  const ClockMapping mapping = map_clock(a.device, a.arrival);
  LiveClock live;
  for (std::size_t i = 0; i < a.device.size(); ++i) {
    const std::int64_t host = live.host_us(a.device[i], a.arrival[i]);
    if (i > 10) {
      EXPECT_LT(std::abs(host - mapping.host_us[i]), 1000);
    }
  }
}

TEST(VirtualClock, PassesByWaitingAlone) {
  VirtualClock clock;
  EXPECT_EQ(clock.now_us(), 0);
  clock.wait(1.5);
  clock.wait(-1);
  EXPECT_EQ(clock.now_us(), 1500000);
  EXPECT_EQ(clock.real_seconds(), 0);
}

TEST(SteadyClock, NeverRunsBackwards) {
  SteadyClock clock(100);
  std::int64_t last = clock.now_us();
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t now = clock.now_us();
    EXPECT_GE(now, last);
    last = now;
  }
  clock.wait(0.1);
  EXPECT_GE(clock.now_us(), last + 100000);
}

}  // namespace
}  // namespace batten::test
