#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>

#include <Eigen/Geometry>

#include "batten/capture/clock.hpp"
#include "batten/capture/line_protocol.hpp"
#include "batten/capture/readings_detail.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::detail {

namespace {

// A sample whose time is this far from those around it, which agree, has a wrong time (microseconds).
constexpr std::int64_t kLargestTimeStep = 1000000;
// The orientation of a raw sample comes from fused ones at most this far away.
constexpr std::int64_t kLargestFusedStep = 60000;
// No hand is faster along an object, metres per second; and a wheel may settle by so many metres.
constexpr double kLargestSpeed = 1.5;
constexpr double kLargestJump = 0.005;
constexpr std::size_t kComplaintsTold = 5;

/// A sample or a button as it was sent, raw or fused.
struct Timed {
  LineMessage message;
  std::int64_t arrival_us = 0, device_us = 0, host_us = 0;
};

std::uint32_t seq_of(const LineMessage& message) {
  if (const auto* s = std::get_if<RawSample>(&message)) return s->seq;
  if (const auto* q = std::get_if<FusedSample>(&message)) return q->seq;
  if (const auto* k = std::get_if<ButtonPress>(&message)) return k->seq;
  return 0;
}

std::uint32_t time_of(const LineMessage& message) {
  if (const auto* s = std::get_if<RawSample>(&message)) return s->t_us;
  if (const auto* q = std::get_if<FusedSample>(&message)) return q->t_us;
  if (const auto* k = std::get_if<ButtonPress>(&message)) return k->t_us;
  return 0;
}

std::optional<std::int32_t> ticks_of(const LineMessage& message) {
  if (const auto* s = std::get_if<RawSample>(&message)) return s->ticks;
  if (const auto* q = std::get_if<FusedSample>(&message)) return q->ticks;
  return std::nullopt;
}

class LineDecoder {
 public:
  LineDecoder(Readings& readings, DecodedRecording& decoded) : readings_(readings), decoded_(decoded) {}

  void decode(const Recording& recording) {
    for (const CaptureEvent& event : recording.events)
      if (event.kind == EventKind::Line) take(event);
    if (decoded_.report.n_lines == 0) return;
    tell_complaints();
    drop_wrong_times();
    map_times();
    count_missing();
    make_readings();
    if (header_.axes) readings_.axes = *header_.axes;
    if (header_.wheel_offset_m != 0)
      decoded_.warnings.emplace_back(
          "the wheel does not touch where the sensor is (wheel_offset_m); distances are those of the wheel");
  }

 private:
  void take(const CaptureEvent& event) {
    DecodeReport& report = decoded_.report;
    ++report.n_lines;
    Timed timed;
    try {
      timed.message = parse_line(event.payload, header_.checked);
    } catch (const InvalidInput&) {
      ++report.n_refused;
      return;
    }
    if (const auto* header = std::get_if<DeviceHeader>(&timed.message)) {
      header_ = *header;
    } else if (const auto* complaint = std::get_if<DeviceComplaint>(&timed.message)) {
      complaints_.insert(complaint->text);
    } else if (!already_seen(timed.message)) {
      timed.arrival_us = lines_.empty() ? event.time_us : std::max(event.time_us, lines_.back().arrival_us);
      timed.device_us = time_(time_of(timed.message));
      lines_.push_back(std::move(timed));
    }
  }

  /// What networks deliver twice comes within a few lines.
  bool already_seen(const LineMessage& message) {
    for (std::size_t i = lines_.size(), end = i < 8 ? 0 : i - 8; i-- > end;) {
      const LineMessage& other = lines_[i].message;
      if (other.index() != message.index() || seq_of(other) != seq_of(message) ||
          time_of(other) != time_of(message))
        continue;
      ++decoded_.report.n_duplicates;
      return true;
    }
    return false;
  }

  void tell_complaints() {
    std::size_t n = 0;
    for (const std::string& text : complaints_)
      if (++n <= kComplaintsTold) decoded_.warnings.push_back(concat("the device says: ", text));
  }

  void drop_wrong_times() {
    const auto far = [](const Timed& a, const Timed& b) {
      return std::abs(a.device_us - b.device_us) > kLargestTimeStep;
    };
    std::vector<Timed> kept;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const bool wrong = !kept.empty() && i + 1 < lines_.size() && far(kept.back(), lines_[i]) &&
                         far(lines_[i], lines_[i + 1]) && !far(kept.back(), lines_[i + 1]);
      if (wrong)
        ++decoded_.report.n_refused;
      else
        kept.push_back(std::move(lines_[i]));
    }
    lines_ = std::move(kept);
  }

  void map_times() {
    std::vector<std::int64_t> device, arrival;
    for (const Timed& line : lines_) {
      device.push_back(line.device_us);
      arrival.push_back(line.arrival_us);
    }
    const ClockMapping mapping = map_clock(device, arrival);
    for (std::size_t i = 0; i < lines_.size(); ++i) lines_[i].host_us = mapping.host_us[i];
    decoded_.report.clock_rate = mapping.rate;
    decoded_.report.n_clock_jumps = static_cast<long>(mapping.jumps.size());
    std::stable_sort(lines_.begin(), lines_.end(),
                     [](const Timed& a, const Timed& b) { return a.host_us < b.host_us; });
  }

  /// Devices number all lines together, or each kind by itself: whichever misses fewer.
  void count_missing() {
    std::array<Unwrapper, 4> unwrap;
    std::array<std::set<std::int64_t>, 4> seen;  // raw, fused, buttons, all
    for (const Timed& line : lines_) {
      const std::size_t kind = line.message.index() - 1;
      seen[kind].insert(unwrap[kind](seq_of(line.message)));
      seen[3].insert(unwrap[3](seq_of(line.message)));
    }
    // A device that counts anew misses nothing by that: large gaps are restarts.
    const auto missing = [](const std::set<std::int64_t>& numbers) {
      long n = 0;
      for (auto at = numbers.begin(), next = at; at != numbers.end() && ++next != numbers.end(); ++at)
        if (*next - *at <= 10000) n += static_cast<long>(*next - *at - 1);
      return n;
    };
    decoded_.report.n_missing += std::min(missing(seen[3]), missing(seen[0]) + missing(seen[1]));
  }

  void make_readings() {
    std::vector<const Timed*> raw, fused;
    for (const Timed& line : lines_) {
      if (std::holds_alternative<RawSample>(line.message)) raw.push_back(&line);
      if (std::holds_alternative<FusedSample>(line.message)) fused.push_back(&line);
      if (const auto* press = std::get_if<ButtonPress>(&line.message))
        readings_.keys.emplace_back(line.host_us, press->key);
    }
    const std::size_t first = readings_.readings.size();
    for (const Timed* line : raw.empty() ? fused : raw) {
      Reading reading;
      reading.time_us = line->host_us;
      if (const auto* sample = std::get_if<RawSample>(&line->message)) {
        reading.accelerometer = sample->accelerometer;
        reading.magnetometer = sample->magnetometer;
        reading.gyroscope = sample->gyroscope;
      }
      if (const auto ticks = ticks_of(line->message))
        reading.distance = *ticks;  // scaled below, when those that jump are known
      readings_.readings.push_back(reading);
    }
    add_orientations(fused, first);
    scale_distances(first);
  }

  void add_orientations(const std::vector<const Timed*>& fused, std::size_t first) {
    std::size_t next = 0;
    for (std::size_t i = first; i < readings_.readings.size(); ++i) {
      Reading& reading = readings_.readings[i];
      while (next < fused.size() && fused[next]->host_us < reading.time_us) ++next;
      const Timed* after = next < fused.size() ? fused[next] : nullptr;
      const Timed* before = next > 0 ? fused[next - 1] : nullptr;
      if (after != nullptr && after->host_us - reading.time_us > kLargestFusedStep) after = nullptr;
      if (before != nullptr && reading.time_us - before->host_us > kLargestFusedStep) before = nullptr;
      if (after == nullptr && before == nullptr) continue;
      const auto q = [](const Timed* t) { return std::get<FusedSample>(t->message).orientation; };
      Eigen::Quaterniond orientation = q(after != nullptr ? after : before);
      if (after != nullptr && before != nullptr) {
        const auto span = static_cast<double>(after->host_us - before->host_us);
        const auto part = static_cast<double>(reading.time_us - before->host_us);
        orientation = q(before).slerp(span > 0 ? part / span : 1, q(after)).normalized();
      }
      reading.orientation << orientation.w(), orientation.x(), orientation.y(), orientation.z();
    }
  }

  /// Ticks, which wrap and may begin anew, to metres that go on.
  void scale_distances(std::size_t first) {
    if (header_.ticks_per_m <= 0) {
      bool any = false;
      for (std::size_t i = first; i < readings_.readings.size(); ++i) {
        any = any || !std::isnan(readings_.readings[i].distance);
        readings_.readings[i].distance = kMissingValue;
      }
      if (any)
        decoded_.warnings.emplace_back(
            "the device counts ticks but does not say how many make a metre; distances are missing, give "
            "ticks_per_m in its header");
      return;
    }
    Unwrapper unwrap;
    double offset = 0, last = kMissingValue;
    std::int64_t last_time = 0;
    for (std::size_t i = first; i < readings_.readings.size(); ++i) {
      Reading& reading = readings_.readings[i];
      if (std::isnan(reading.distance)) continue;
      const auto ticks = static_cast<std::uint32_t>(static_cast<std::int64_t>(reading.distance));
      reading.distance = static_cast<double>(unwrap(ticks)) / header_.ticks_per_m + offset;
      const double seconds = static_cast<double>(reading.time_us - last_time) * 1e-6;
      if (!std::isnan(last) && std::abs(reading.distance - last) > kLargestSpeed * seconds + kLargestJump) {
        // One wrong number returns with the next; a device that counts anew does not.
        offset += last - reading.distance;
        reading.distance = last;
        reading.distance_lost_before = true;
        ++decoded_.report.n_restarts;
      }
      last = reading.distance;
      last_time = reading.time_us;
    }
  }

  Readings& readings_;
  DecodedRecording& decoded_;
  DeviceHeader header_;
  std::set<std::string> complaints_;
  std::vector<Timed> lines_;
  Unwrapper time_;
};

}  // namespace

void add_line_readings(const Recording& recording, Readings& readings, DecodedRecording& decoded) {
  LineDecoder(readings, decoded).decode(recording);
}

}  // namespace batten::detail
