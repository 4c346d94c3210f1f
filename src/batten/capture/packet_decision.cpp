#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "batten/capture/morphorider.hpp"
#include "batten/capture/packet_limits_detail.hpp"
#include "batten/core/statistics.hpp"

namespace batten {

namespace {

using Fate = PacketDecision::Fate;

// Packets farther apart than this do not foretell each other (microseconds).
constexpr std::int64_t kGap = 150000;
// Rounding of the ticks themselves and of four neighbours in the cubic amounts to 1.33 at most.
constexpr double kSmallestTicksTolerance = 1.5;
// In full scales: a quarter of a degree of gravity at 2 g.
constexpr double kSmallestVectorTolerance = 2e-3;
constexpr double kDeviations = 4.5;
// Deviations are measured over blocks of this many packets and both neighbouring ones.
constexpr std::size_t kBlock = 32;
using detail::kLargestIndexStep, detail::kLargestTicksPerPacket;
// A hand is never faster on an object: ticks per second of a wheel of some centimetres.
constexpr double kLargestTicksPerSecond = 6000;
constexpr int kMostPasses = 30;
// Neighbours are not looked for farther away than this, so that the cost stays linear.
constexpr std::size_t kFarthest = 40;

/// Control bytes that are the same in nine of ten packets; others are not looked at.
std::array<std::optional<std::uint8_t>, 4> constant_bytes(const std::vector<MorphoriderPacket>& packets) {
  std::array<std::optional<std::uint8_t>, 4> constant;
  for (std::size_t k = 0; k < 4; ++k) {
    std::unordered_map<int, std::size_t> counts;
    for (const MorphoriderPacket& p : packets) ++counts[p.control[k]];
    for (const auto& [value, n] : counts)
      if (10 * n >= 9 * packets.size()) constant[k] = static_cast<std::uint8_t>(value);
  }
  return constant;
}

/// One of the seven numbers of a packet as a function of time: ticks, and two vectors.
struct Channel {
  std::vector<double> values;
  bool cubic = false;
  double smallest_tolerance = 0;
};

class Decider {
 public:
  Decider(const std::vector<MorphoriderPacket>& packets, const std::vector<std::int64_t>& times)
      : packets_(packets), times_(times), good_(packets.size(), true) {}

  PacketDecision decide(const std::vector<std::string>& raw) {
    const std::size_t n = packets_.size();
    result_.fate.assign(n, Fate::Kept);
    result_.ticks.assign(n, 0);
    result_.index.assign(n, 0);
    result_.distance_lost_before.assign(n, false);
    mark_duplicates(raw);
    check_control_bytes();
    check_indices();
    make_channels();
    const std::vector<bool> sound = good_;  // by bytes and index
    coarse_ticks();
    take_out_the_worst();
    look_once_more(sound);
    take_out_the_worst();
    finish();
    return std::move(result_);
  }

 private:
  void mark_duplicates(const std::vector<std::string>& raw) {
    for (std::size_t i = 0; i < raw.size(); ++i)
      for (std::size_t j = i; j-- > 0 && i - j <= 3;)
        if (raw[i] == raw[j]) {
          result_.fate[i] = Fate::Duplicate;
          good_[i] = false;
        }
    for (std::size_t i = 0; i < raw.size(); ++i)
      if (good_[i]) order_.push_back(i);
  }

  void check_control_bytes() {
    const auto constant = constant_bytes(packets_);
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      for (std::size_t k = 0; k < 4; ++k)
        if (constant[k] && packets_[i].control[k] != *constant[k]) good_[i] = false;
      if (std::abs(packets_[i].small) >= MorphoriderPacket::kTicksPerTurn) good_[i] = false;
    }
  }

  /// An index is right where two of the six packets around count along with it. Between such packets one that
  /// lies in a gap of the count is right, too.
  void check_indices() {
    const std::size_t n = order_.size();
    std::vector<bool> counted(n, false);
    for (std::size_t a = 0; a < n; ++a) {
      int agreeing = 0;
      for (std::size_t b = a < 3 ? 0 : a - 3; b < std::min(n, a + 4); ++b) {
        if (a == b) continue;
        const std::size_t low = std::min(a, b), high = std::max(a, b);
        const int step = index_step(packets_[order_[low]].index, packets_[order_[high]].index);
        if (step == static_cast<int>(high - low)) ++agreeing;
      }
      counted[a] = agreeing >= std::min<int>(2, static_cast<int>(n) - 1);
    }
    for (std::size_t a = 0; a < n; ++a) {
      if (counted[a]) continue;
      std::size_t before = a, after = a + 1;
      while (before > 0 && !counted[before - 1]) --before;
      while (after < n && !counted[after]) ++after;
      if (before > 0 && after < n && fits_between(before - 1, a, after)) continue;
      good_[order_[a]] = false;
    }
  }

  bool fits_between(std::size_t before, std::size_t at, std::size_t after) const {
    const auto index = [this](std::size_t a) { return packets_[order_[a]].index; };
    const int whole = index_step(index(before), index(after));
    const int first = index_step(index(before), index(at)), second = index_step(index(at), index(after));
    return first >= 1 && second >= 1 && first + second == whole &&
           whole <= kLargestIndexStep + static_cast<int>(after - before);
  }

  void make_channels() {
    channels_.resize(7);
    channels_[0].cubic = true;
    channels_[0].smallest_tolerance = kSmallestTicksTolerance;
    for (const MorphoriderPacket& p : packets_) {
      channels_[0].values.push_back(p.ticks());
      for (std::size_t k = 0; k < 3; ++k) {
        channels_[1 + k].values.push_back(p.accelerometer[static_cast<Eigen::Index>(k)]);
        channels_[4 + k].values.push_back(p.magnetometer[static_cast<Eigen::Index>(k)]);
      }
    }
    for (std::size_t c = 1; c < 7; ++c) channels_[c].smallest_tolerance = kSmallestVectorTolerance;
  }

  /// Ticks that no hand can reach from the median of six neighbours say nothing about their neighbours.
  void coarse_ticks() {
    std::vector<std::size_t> unbelievable;
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      if (!good_[i]) continue;
      std::vector<double> around;
      for (const std::size_t j : neighbours(i, 3)) around.push_back(channels_[0].values[j]);
      if (around.size() < 3) continue;
      if (std::abs(channels_[0].values[i] - median(around)) > 4 * kLargestTicksPerPacket)
        unbelievable.push_back(i);
    }
    for (const std::size_t i : unbelievable) good_[i] = false;
  }

  /// Up to `each` believed packets before and after, none across a gap, in the order of time.
  std::vector<std::size_t> neighbours(std::size_t i, std::size_t each) const {
    std::vector<std::size_t> found;
    const std::size_t first = i < kFarthest ? 0 : i - kFarthest,
                      end = std::min(packets_.size(), i + kFarthest);
    for (std::size_t j = i, last = i; j-- > first && found.size() < each && times_[last] - times_[j] < kGap;)
      if (good_[j]) {
        found.push_back(j);
        last = j;
      }
    std::reverse(found.begin(), found.end());
    const std::size_t n_before = found.size();
    std::size_t last = i;
    for (std::size_t j = i + 1; j < end && found.size() - n_before < each && times_[j] - times_[last] < kGap;
         ++j)
      if (good_[j]) {
        found.push_back(j);
        last = j;
      }
    return found;
  }

  /// What the neighbours foretell, by Lagrange's cubic through four of them or a line through six. Where all
  /// lie on one side, a line through them; `factor` says by how much surer the other cases are.
  std::optional<double> foretold(std::size_t i, const Channel& channel,
                                 const std::vector<std::size_t>& around, double& factor) const {
    factor = 1;
    if (around.size() < 2) return std::nullopt;
    const auto x = [&](std::size_t j) { return static_cast<double>(times_[j] - times_[i]) * 1e-4; };
    const bool both_sides = around.front() < i && around.back() > i;
    if (channel.cubic && both_sides && around.size() == 4 && around[1] < i && around[2] > i) {
      double value = 0;
      for (const std::size_t j : around) {
        double weight = 1;
        for (const std::size_t k : around)
          if (k != j && x(j) != x(k)) weight *= -x(k) / (x(j) - x(k));
        value += weight * channel.values[j];
      }
      return value;
    }
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    const auto n = static_cast<double>(around.size());
    for (const std::size_t j : around) {
      sx += x(j);
      sy += channel.values[j];
      sxx += x(j) * x(j);
      sxy += x(j) * channel.values[j];
    }
    if (!both_sides) factor = 3;
    const double determinant = n * sxx - sx * sx;
    return determinant > 1e-9 ? (sxx * sy - sx * sxy) / determinant : sy / n;
  }

  /// |value − foretold| of a packet; NaN where too few neighbours are left.
  double residual(std::size_t i, const Channel& channel, double& factor) const {
    const std::optional<double> value = foretold(i, channel, neighbours(i, channel.cubic ? 2 : 3), factor);
    return value ? std::abs(channel.values[i] - *value) : std::nan("");
  }

  /// Tolerances per block: what is usual there among the packets that are believed.
  std::vector<double> tolerances(const Channel& channel) const {
    const std::size_t n_blocks = packets_.size() / kBlock + 1;
    std::vector<std::vector<double>> blocks(n_blocks);
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      double factor = 1;
      const double r = good_[i] ? residual(i, channel, factor) : std::nan("");
      if (!std::isnan(r) && factor == 1) blocks[i / kBlock].push_back(r);
    }
    std::vector<double> result(n_blocks);
    for (std::size_t b = 0; b < n_blocks; ++b) {
      std::vector<double> near;
      for (std::size_t k = b == 0 ? 0 : b - 1; k < std::min(n_blocks, b + 2); ++k)
        near.insert(near.end(), blocks[k].begin(), blocks[k].end());
      result[b] = std::max(channel.smallest_tolerance, kDeviations * kMadToDeviation * upper_median(near));
    }
    return result;
  }

  /// How far ticks lie outside those of the believed packets before and after: a wheel that rolls on, or
  /// stands, passes all ticks in their order. Slight errors show here that the cubic lets pass.
  double out_of_order(std::size_t i) const {
    const std::vector<std::size_t> around = neighbours(i, 1);
    if (around.size() < 2) return 0;
    const std::vector<double>& ticks = channels_[0].values;
    const double low = std::min(ticks[around[0]], ticks[around[1]]);
    const double high = std::max(ticks[around[0]], ticks[around[1]]);
    return std::max({0.0, low - ticks[i], ticks[i] - high});
  }

  /// The largest of all residuals of a packet in tolerances; 0 where nothing is foretold.
  double badness(std::size_t i) const {
    const double beyond = out_of_order(i);
    double worst = beyond > 0 ? 1 + beyond : 0;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      double factor = 1;
      const double r = residual(i, channels_[c], factor);
      if (!std::isnan(r)) worst = std::max(worst, r / (factor * tolerances_[c][i / kBlock]));
    }
    return worst;
  }

  void measure_tolerances() {
    tolerances_.clear();
    for (const Channel& channel : channels_) tolerances_.push_back(tolerances(channel));
  }

  /// Packets that are the worst among those around them, until all are within tolerance. A wrong packet makes
  /// its neighbours look bad as well, but never as bad as itself.
  void take_out_the_worst() {
    measure_tolerances();
    std::vector<double> bad(packets_.size(), 0);
    std::vector<bool> stale(packets_.size(), true);
    for (int pass = 0; pass < kMostPasses; ++pass) {
      for (std::size_t i = 0; i < packets_.size(); ++i)
        if (stale[i]) bad[i] = good_[i] ? badness(i) : 0;
      std::fill(stale.begin(), stale.end(), false);
      std::vector<std::size_t> worst;
      for (std::size_t i = 0; i < packets_.size(); ++i) {
        if (!good_[i] || bad[i] <= 1) continue;
        bool is_worst = true;
        for (const std::size_t j : neighbours(i, 3))
          is_worst = is_worst && (bad[j] < bad[i] || (bad[j] == bad[i] && j > i));
        if (is_worst) worst.push_back(i);
      }
      if (worst.empty()) return;
      for (const std::size_t i : worst) {
        for (const std::size_t j : neighbours(i, 6)) stale[j] = true;
        good_[i] = false;
        bad[i] = 0;
      }
    }
  }

  void look_once_more(const std::vector<bool>& sound) {
    measure_tolerances();
    std::vector<std::size_t> right;
    for (std::size_t i = 0; i < packets_.size(); ++i)
      if (!good_[i] && sound[i] && neighbours(i, 1).size() == 2 && badness(i) <= 1) right.push_back(i);
    for (const std::size_t i : right) good_[i] = true;
  }

  /// Counts index and ticks on over wraps and restarts, and says where the wheel may have turned uncounted.
  void finish() {
    bool first = true;
    std::size_t last = 0;
    std::int64_t index = 0, offset = 0;
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      if (!good_[i]) {
        if (result_.fate[i] == Fate::Kept) result_.fate[i] = Fate::Refused;
        continue;
      }
      const std::int64_t ticks = packets_[i].ticks();
      if (!first) {
        const double seconds = static_cast<double>(times_[i] - times_[last]) * 1e-6;
        const int step = index_step(packets_[last].index, packets_[i].index);
        const bool same_count = step >= 1 && step <= kLargestIndexStep + static_cast<int>(i - last);
        if (!same_count) ++result_.n_restarts;
        index += same_count ? step : 1;
        const std::int64_t change = ticks + offset - result_.ticks[last];
        if (static_cast<double>(std::abs(change)) >
            kLargestTicksPerSecond * seconds + kLargestTicksPerPacket) {
          result_.distance_lost_before[i] = true;
          offset -= change;
        }
      }
      result_.index[i] = index;
      result_.ticks[i] = ticks + offset;
      last = i;
      first = false;
    }
  }

  const std::vector<MorphoriderPacket>& packets_;
  const std::vector<std::int64_t>& times_;
  std::vector<bool> good_;
  std::vector<std::size_t> order_;  // packets without duplicates
  std::vector<Channel> channels_;
  std::vector<std::vector<double>> tolerances_;
  PacketDecision result_;
};

}  // namespace

PacketDecision decide_packets(const std::vector<std::string>& packets,
                              const std::vector<std::int64_t>& time_us, PacketForm form) {
  std::vector<MorphoriderPacket> decoded;
  decoded.reserve(packets.size());
  for (const std::string& bytes : packets) decoded.push_back(decode_packet(bytes, form));
  return Decider(decoded, time_us).decide(packets);
}

}  // namespace batten
