#include "batten/capture/clock.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

namespace batten {

namespace {

// A device whose time runs ahead of all earlier ones by this much was set forward (microseconds).
constexpr std::int64_t kForwardJump = 100000;
// One whose samples all come later by this much, over so many samples, was set back.
constexpr std::int64_t kBackwardJump = 500000;
constexpr std::size_t kBackwardSamples = 50;
// Slopes of shorter stretches tell more of the delays than of the clock.
constexpr std::int64_t kShortestForRate = 10000000;
constexpr double kLargestRateError = 1e-3;
constexpr std::int64_t kLiveWindow = 30000000;

std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Line below the delays of samples [begin, end) that is nearest to them on average.
struct Envelope {
  double offset = 0, slope = 0, origin = 0;
  double at(double device) const { return offset + slope * (device - origin); }
};

Envelope lower_envelope(const std::vector<std::int64_t>& device, const std::vector<std::int64_t>& arrival,
                        std::size_t begin, std::size_t end) {
  Envelope envelope;
  std::vector<std::pair<double, double>> points;
  double mean = 0;
  for (std::size_t i = begin; i < end; ++i) {
    points.emplace_back(static_cast<double>(device[i]), static_cast<double>(arrival[i] - device[i]));
    mean += points.back().first / static_cast<double>(end - begin);
  }
  std::sort(points.begin(), points.end());
  envelope.origin = mean;
  envelope.offset = std::min_element(points.begin(), points.end(), [](auto& a, auto& b) {
                      return a.second < b.second;
                    })->second;
  if (points.back().first - points.front().first < kShortestForRate) return envelope;
  std::vector<std::pair<double, double>> hull;
  for (const auto& p : points) {
    while (hull.size() >= 2) {
      const auto &a = hull[hull.size() - 2], &b = hull.back();
      if ((b.second - a.second) * (p.first - a.first) < (p.second - a.second) * (b.first - a.first)) break;
      hull.pop_back();
    }
    hull.push_back(p);
  }
  // The mean distance of the points from a line below them depends on its height at their mean alone.
  for (std::size_t k = 0; k + 1 < hull.size(); ++k) {
    const auto &a = hull[k], &b = hull[k + 1];
    if (b.first < mean || b.first == a.first) continue;
    const double slope = (b.second - a.second) / (b.first - a.first);
    if (std::abs(slope) > kLargestRateError) break;
    envelope.slope = slope;
    envelope.offset = a.second + slope * (mean - a.first);
    break;
  }
  return envelope;
}

/// Where stretches begin: first samples after jumps of the device's clock.
std::vector<std::size_t> find_jumps(const std::vector<std::int64_t>& device,
                                    const std::vector<std::int64_t>& arrival) {
  std::vector<std::size_t> jumps;
  std::int64_t least = 0;
  for (std::size_t i = 0; i < device.size(); ++i) {
    const std::int64_t delay = arrival[i] - device[i];
    if (i == 0) {
      least = delay;
      continue;
    }
    bool jumped = delay < least - kForwardJump;
    if (!jumped && delay > least + kBackwardJump) {
      jumped = device.size() - i >= kBackwardSamples;
      for (std::size_t k = i; jumped && k < i + kBackwardSamples; ++k)
        jumped = arrival[k] - device[k] > least + kBackwardJump;
    }
    if (jumped) {
      jumps.push_back(i);
      least = delay;
    }
    least = std::min(least, delay);
  }
  return jumps;
}

}  // namespace

SteadyClock::SteadyClock(double speed) : speed_(speed), start_ns_(steady_ns()) {}

std::int64_t SteadyClock::now_us() {
  return static_cast<std::int64_t>(static_cast<double>(steady_ns() - start_ns_) * speed_ / 1000);
}

void SteadyClock::wait(double seconds) {
  if (seconds > 0) std::this_thread::sleep_for(std::chrono::duration<double>(seconds / speed_));
}

void VirtualClock::wait(double seconds) {
  if (seconds > 0) now_us_ += std::llround(seconds * 1e6);
}

std::int64_t Unwrapper::operator()(std::uint32_t value) {
  unwrapped_ = started_ ? unwrapped_ + static_cast<std::int32_t>(value - last_) : value;
  last_ = value;
  started_ = true;
  return unwrapped_;
}

ClockMapping map_clock(const std::vector<std::int64_t>& device_us,
                       const std::vector<std::int64_t>& arrival_us) {
  ClockMapping mapping;
  mapping.host_us.resize(device_us.size());
  mapping.jumps = find_jumps(device_us, arrival_us);
  std::size_t longest = 0, begin = 0;
  for (std::size_t k = 0; k <= mapping.jumps.size() && begin < device_us.size(); ++k) {
    const std::size_t end = k < mapping.jumps.size() ? mapping.jumps[k] : device_us.size();
    const Envelope envelope = lower_envelope(device_us, arrival_us, begin, end);
    for (std::size_t i = begin; i < end; ++i)
      mapping.host_us[i] = device_us[i] + std::llround(envelope.at(static_cast<double>(device_us[i])));
    if (end - begin > longest) {
      longest = end - begin;
      mapping.rate = 1 + envelope.slope;
    }
    begin = end;
  }
  return mapping;
}

std::int64_t LiveClock::host_us(std::int64_t device_us, std::int64_t arrival_us) {
  const std::int64_t delay = arrival_us - device_us;
  const bool restarted = device_us < last_device_us_ - 1000000;
  if (!least_.empty() && (restarted || delay < least_.front().second - kForwardJump)) least_.clear();
  last_device_us_ = device_us;
  while (!least_.empty() && least_.back().second >= delay) least_.pop_back();
  least_.emplace_back(arrival_us, delay);
  while (least_.front().first < arrival_us - kLiveWindow) least_.pop_front();
  return device_us + least_.front().second;
}

}  // namespace batten
