#pragma once
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

namespace batten {

/// The time of the computer that records: microseconds that never run backwards.
class HostClock {
 public:
  virtual ~HostClock() = default;
  /// Microseconds since the clock began.
  virtual std::int64_t now_us() = 0;
  /// Lets time pass.
  virtual void wait(double seconds) = 0;
  /// Real seconds that one second of this clock takes; 0 where time passes only by wait().
  virtual double real_seconds() const = 0;
};

/// Real time since construction, from a clock that nobody sets, or `speed` times as much.
class SteadyClock : public HostClock {
 public:
  /// @param speed above 0: 2 runs twice as fast as the time of the world.
  explicit SteadyClock(double speed = 1);
  std::int64_t now_us() override;
  void wait(double seconds) override;
  double real_seconds() const override { return 1 / speed_; }

 private:
  double speed_;
  std::int64_t start_ns_;
};

/// Time that passes by wait() alone: what is recorded with it is the same every time.
class VirtualClock : public HostClock {
 public:
  std::int64_t now_us() override { return now_us_; }
  void wait(double seconds) override;
  double real_seconds() const override { return 0; }

 private:
  std::int64_t now_us_ = 0;
};

/// Counts a 32-bit counter on over its wraps: differences of less than 2³¹ to either side are taken as such.
class Unwrapper {
 public:
  /// The count of a reading, its wraps added up.
  std::int64_t operator()(std::uint32_t value);

 private:
  bool started_ = false;
  std::uint32_t last_ = 0;
  std::int64_t unwrapped_ = 0;
};

/// When samples of a device were taken, in host time.
struct ClockMapping {
  std::vector<std::int64_t> host_us;  ///< n
  /// Where the device's clock was set or started anew: indices of first samples, 0 left out.
  std::vector<std::size_t> jumps;
  double rate = 1;  ///< host seconds per second of the device, of the longest stretch
};

/// Maps device times to host times by the lower envelope of arrival − device time: what comes in bursts, or
/// late, does not move it. Per stretch between jumps of the device's clock a line below all delays and
/// nearest to them on average (an edge of their lower hull); its slope is taken where the stretch lasts ten
/// seconds, and where it is below 1e-3. O(n).
/// @param device_us n, in the order of arrival, unwrapped. @param arrival_us n, not decreasing.
ClockMapping map_clock(const std::vector<std::int64_t>& device_us,
                       const std::vector<std::int64_t>& arrival_us);

/// The same while samples come in, without the rate: the least delay of the last half minute. Memory is
/// bounded.
class LiveClock {
 public:
  /// Host time of a sample. @param arrival_us not decreasing from call to call.
  std::int64_t host_us(std::int64_t device_us, std::int64_t arrival_us);

 private:
  std::deque<std::pair<std::int64_t, std::int64_t>> least_;  // (arrival, delay), both increasing
  std::int64_t last_device_us_ = 0;
};

}  // namespace batten
