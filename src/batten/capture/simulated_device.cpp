#include "batten/capture/simulated_device.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/capture/line_protocol.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/rotation/wahba.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Streams of random numbers, one per effect.
enum SimulatorStream : std::uint64_t { kSensorNoise = 301, kFaults };

constexpr double kLift = 0.8;         // seconds from the end of a curve to the start of the next
constexpr double kBefore = 0.5;       // seconds of rest before the motion
constexpr double kAfter = 0.3;        // and after it
constexpr double kTypingStep = 0.05;  // seconds between two digits
constexpr std::int64_t kNever = std::int64_t{1} << 60;
// Full scales of the sensors: those of DecodeOptions.
constexpr double kAccelerometerRange = 2 * kUsualGravity, kMagnetometerRange = 130;
constexpr double kTransmission = 0.0019;  // 22 bytes at 115200 baud
constexpr double kLateBy = 0.08;
constexpr std::int64_t kMicroseconds = 1000000;

Vector3d field_of(const DeviceModel& model) {
  return model.field_strength * Vector3d(std::cos(model.inclination), 0, -std::sin(model.inclination));
}

/// The orientation that a row shows. Rows of simulations are exact; so is this then.
Matrix3d orientation_of(const SensorLog& log, Eigen::Index row, const Vector3d& field) {
  return solve_wahba(
      {{Vector3d(0, 0, 1), log.accelerometer.row(row), 1}, {field, log.magnetometer.row(row), 1}});
}

/// The field's direction in the world as the log shows it: its dip is the mean angle between both vectors.
Vector3d field_of(const SensorLog& log) {
  double sine = 0;
  long n = 0;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const Vector3d a = log.accelerometer.row(i), m = log.magnetometer.row(i);
    if (!a.allFinite() || !m.allFinite()) continue;
    sine -= a.normalized().dot(m.normalized());
    ++n;
  }
  const double dip = std::asin(std::clamp(sine / static_cast<double>(std::max(n, 1L)), -1.0, 1.0));
  return {std::cos(dip), 0, -std::sin(dip)};
}

bool usable(const SensorLog& log, Eigen::Index row) {
  return log.curve[static_cast<std::size_t>(row)] != SensorLog::kNone &&
         log.accelerometer.row(row).allFinite() && log.magnetometer.row(row).allFinite() &&
         std::isfinite(log.distance[row]);
}

std::string share_problem(const char* name, double value) {
  return value >= 0 && value <= 1 ? std::string() : concat(name, " must lie in [0, 1], got ", value);
}

}  // namespace

std::optional<std::string> MotionOptions::problem() const {
  if (!(scale > 0)) return concat("scale must be above 0, got ", scale);
  if (!(pace > 0 && pace <= 1000)) return concat("pace must be above 0, at most 1000, got ", pace);
  if (!(rest_s > 0 && rest_s <= 60)) return concat("rest_s must be above 0, at most 60, got ", rest_s);
  return std::nullopt;
}

DeviceMotion::DeviceMotion(const SensorLog& log, const MotionOptions& options) : axes_(log.axes) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const Vector3d field = field_of(log);
  if (options.tumble) add_tumble();
  std::vector<double> row_times(static_cast<std::size_t>(log.n_readings()), -1);
  double clock = times_.empty() ? kBefore : times_.back() + kLift;
  double rolled = 0;
  Eigen::Index last = -1;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    if (!usable(log, i)) continue;
    const auto at = static_cast<std::size_t>(i);
    if (last >= 0 && log.curve[at] == log.curve[static_cast<std::size_t>(last)]) {
      const double way = log.distance[i] - log.distance[last];
      // Rests last as long as typing takes, however many readings the log has of them.
      Eigen::Index from = last, to = i;
      const auto same_place = [&](Eigen::Index a, Eigen::Index b) {
        return log.curve[static_cast<std::size_t>(a)] == log.curve[static_cast<std::size_t>(b)] &&
               log.distance[a] == log.distance[b];
      };
      while (from > 0 && same_place(from - 1, from)) --from;
      while (to + 1 < log.n_readings() && same_place(to, to + 1)) ++to;
      clock += way == 0 ? options.rest_s / static_cast<double>(to - from)
                        : (log.time[i] - log.time[last]) / options.pace;
      rolled += options.scale * way;
    } else if (last >= 0) {
      clock += kLift;
      lifts_.push_back(times_.size() - 1);
    }
    if (!times_.empty() && clock <= times_.back()) clock = times_.back() + 1e-6;
    row_times[at] = clock;
    if (last < 0 && times_.empty()) add(0, orientation_of(log, i, field), 0);
    add(clock, orientation_of(log, i, field), rolled);
    last = i;
  }
  if (last < 0) throw InvalidInput("the motion has no curve with accelerometer, magnetometer and distances");
  add_keys(log, row_times);
  add(std::max(clock, keys_.empty() ? 0 : keys_.back().first) + kAfter, orientations_.back(), rolled);
  find_speeds();
}

/// Speeds at the rows that make cubics between them without turning back: harmonic means.
void DeviceMotion::find_speeds() {
  speeds_.assign(times_.size(), 0);
  for (std::size_t k = 1; k + 1 < times_.size(); ++k) {
    const double before = (distances_[k] - distances_[k - 1]) / (times_[k] - times_[k - 1]);
    const double after = (distances_[k + 1] - distances_[k]) / (times_[k + 1] - times_[k]);
    if (before > 0 && after > 0) speeds_[k] = 2 * before * after / (before + after);
  }
}

void DeviceMotion::add(double seconds, const Matrix3d& orientation, double distance) {
  times_.push_back(seconds);
  orientations_.push_back(orientation);
  distances_.push_back(distance);
}

void DeviceMotion::add_tumble() {
  const DeviceModel ideal;
  const SensorLog tumble = simulate_tumble(ideal, 0);
  const Vector3d field = field_of(tumble);
  for (Eigen::Index i = 0; i < tumble.n_readings(); ++i)
    add(tumble.time[i], orientation_of(tumble, i, field), 0);
}

void DeviceMotion::add_keys(const SensorLog& log, const std::vector<double>& row_times) {
  const auto type = [this](double& at, const std::string& key) {
    keys_.emplace_back(at, key);
    at += kTypingStep;
  };
  const auto n = static_cast<std::size_t>(log.n_readings());
  for (std::size_t i = 0; i < n;) {
    if (row_times[i] < 0) {
      ++i;
      continue;
    }
    const int curve = log.curve[i];
    std::size_t end = i;
    double typed = row_times[i];
    bool begun = false;
    while (end < n && (row_times[end] < 0 || log.curve[end] == curve)) {
      if (row_times[end] < 0) {
        ++end;
        continue;
      }
      // A stay: rows of one node, one after the other.
      std::size_t stay = end + 1;
      while (stay < n && row_times[stay] >= 0 && log.curve[stay] == curve &&
             log.node[end] != SensorLog::kNone && log.node[stay] == log.node[end] &&
             log.distance[static_cast<Eigen::Index>(stay)] == log.distance[static_cast<Eigen::Index>(end)])
        ++stay;
      const double rest = row_times[stay - 1] - row_times[end];
      if (!begun) {
        typed = row_times[end] + 0.1 * rest;
        type(typed, log.curves[static_cast<std::size_t>(curve)].boundary ? "-" : "+");
        begun = true;
      }
      if (log.node[end] != SensorLog::kNone) {
        typed = std::max(typed, row_times[end] + 0.5 * rest);
        for (const char digit : std::to_string(log.node[end])) type(typed, std::string(1, digit));
        type(typed, "enter");
      }
      end = stay;
    }
    type(typed, ".");
    // Of an open end without a node the last reading is later than the last key.
    std::size_t last = end;
    while (last > i && row_times[last - 1] < 0) --last;
    keys_.back().first = std::max(keys_.back().first, row_times[last - 1]);
    i = end;
  }
}

DeviceMotion::State DeviceMotion::at(double seconds) const {
  const auto next = std::upper_bound(times_.begin(), times_.end(), seconds);
  State state;
  if (next == times_.begin() || next == times_.end()) {
    const std::size_t k = next == times_.begin() ? 0 : times_.size() - 1;
    state.orientation = orientations_[k];
    state.rate.setZero();
    state.distance = distances_[k];
    return state;
  }
  const auto k = static_cast<std::size_t>(next - times_.begin()) - 1;
  const double span = times_[k + 1] - times_[k];
  double part = (seconds - times_[k]) / span, pace = 1;
  const double x = part;
  if (std::binary_search(lifts_.begin(), lifts_.end(), k)) {  // carried smoothly from rest to rest
    pace = 6 * part * (1 - part);
    part = part * part * (3 - 2 * part);
  }
  const Vector3d turn = so3_log(nearest_rotation(orientations_[k].transpose() * orientations_[k + 1]));
  state.orientation = orientations_[k] * so3_exp(part * turn);
  state.rate = pace * turn / span;
  const double way = distances_[k + 1] - distances_[k], y = 1 - x;
  state.distance =
      distances_[k] + way * x * x * (3 - 2 * x) + span * x * y * (speeds_[k] * y - speeds_[k + 1] * x);
  return state;
}

std::optional<std::string> SimulatedDeviceOptions::problem() const {
  if (!(rate_hz > 0 && rate_hz <= 1000))
    return concat("rate_hz must be above 0, at most 1000, got ", rate_hz);
  if (!(wheel_m > 0)) return concat("wheel_m must be above 0, got ", wheel_m);
  if (!(noise >= 0)) return concat("noise must be at least 0, got ", noise);
  if (!(burst_s >= 0 && burst_s <= 10)) return concat("burst_s must lie in [0, 10], got ", burst_s);
  if (!(std::abs(clock_ppm) <= 900)) return concat("clock_ppm must lie in [-900, 900], got ", clock_ppm);
  for (const auto& [name, value] : {std::pair{"flip", flip},
                                    {"lose", lose},
                                    {"late", late},
                                    {"duplicate", duplicate},
                                    {"slip_share", slip_share}})
    if (const std::string problem = share_problem(name, value); !problem.empty()) return problem;
  return std::nullopt;
}

SimulatedDevice::SimulatedDevice(DeviceMotion motion, const SimulatedDeviceOptions& options)
    : motion_(std::move(motion)),
      options_(options),
      noise_(options.seed, kSensorNoise),
      faults_(options.seed, kFaults) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const DeviceModel real = make_device(options.seed, options.noise);
  if (options.distortion) {
    model_ = real;
  } else {
    model_.accelerometer_noise = real.accelerometer_noise;
    model_.magnetometer_noise = real.magnetometer_noise;
    model_.gyroscope_noise = real.gyroscope_noise;
  }
}

double SimulatedDevice::wheel_distance(double t) const {
  double distance = motion_.at(t).distance;
  if (options_.slip.duration > 0 && t > options_.slip.start) {
    const double end = std::min(t, options_.slip.start + options_.slip.duration);
    distance -= options_.slip_share * (motion_.at(end).distance - motion_.at(options_.slip.start).distance);
  }
  return distance - ticks_zero_m_;
}

void SimulatedDevice::measure(double t, Vector3d& acc, Vector3d& mag, Vector3d& gyr) {
  const DeviceMotion::State state = motion_.at(t);
  const Vector3d up(0, 0, model_.gravity);
  acc = model_.accelerometer_distortion * (state.orientation.transpose() * up) + model_.accelerometer_offset +
        model_.accelerometer_noise * noise_.normal3();
  mag = model_.magnetometer_distortion * (state.orientation.transpose() * field_of(model_)) +
        model_.magnetometer_offset + model_.magnetometer_noise * noise_.normal3();
  gyr = state.rate + model_.gyroscope_bias + model_.gyroscope_noise * noise_.normal3();
}

void SimulatedDevice::send(std::string bytes, std::int64_t due_us) {
  std::string arriving;
  for (const char byte : bytes) {
    if (faults_.uniform() < options_.lose) continue;
    arriving += byte;
    if (faults_.uniform() < options_.flip)
      arriving.back() = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U << faults_.below(8)));
  }
  outgoing_.emplace(due_us, arriving);
}

void SimulatedDevice::receive(std::string_view bytes, std::int64_t now_us) {
  if (!started_) {
    started_ = true;
    start_us_ = counting_since_us_ = now_us;
  }
  emit_lines(now_us);
  if (options_.kind == SimulatedDeviceOptions::Kind::Morphorider) {
    for (const char byte : bytes)
      if (byte == MorphoriderPacket::kRequest) answer_request(now_us);
    return;
  }
  for (const char byte : bytes) {
    if (byte != '\n') {
      request_ += byte;
      continue;
    }
    if (request_ == "?") {
      DeviceHeader header;
      header.device = "simulator";
      header.axes = motion_.axes();
      header.ticks_per_m = MorphoriderPacket::kTicksPerTurn / options_.wheel_m;
      header.rate_hz = options_.rate_hz;
      send(format_line(header) + "\n", now_us + 2000);
    }
    request_.clear();
  }
}

void SimulatedDevice::answer_request(std::int64_t now_us) {
  const double t = seconds(now_us);
  if (options_.restart_s >= 0 && t >= options_.restart_s && !restarted_) {
    restarted_ = true;
    index_ = 0;
  }
  if (options_.reboot_s >= 0 && t >= options_.reboot_s && !rebooted_) {
    rebooted_ = true;
    index_ = 0;
    ticks_zero_m_ = wheel_distance(t);
  }
  MorphoriderPacket packet;
  packet.control = {0xA5, 0x16, 0x02, 0x00};
  const bool sign_magnitude =
      options_.form == PacketForm::BigSignMagnitude || options_.form == PacketForm::LittleSignMagnitude;
  packet.index = static_cast<std::uint16_t>(index_ % (sign_magnitude ? 0x8000U : 0x10000U));
  ++index_;
  const auto ticks =
      static_cast<int>(std::floor(wheel_distance(t) / options_.wheel_m * MorphoriderPacket::kTicksPerTurn));
  packet.big = static_cast<int>(std::floor(static_cast<double>(ticks) / MorphoriderPacket::kTicksPerTurn));
  packet.small = ticks - packet.big * MorphoriderPacket::kTicksPerTurn;
  Vector3d acc, mag, gyr;
  measure(t, acc, mag, gyr);
  packet.accelerometer = (acc / kAccelerometerRange).cwiseMax(-1).cwiseMin(1);
  packet.magnetometer = (mag / kMagnetometerRange).cwiseMax(-1).cwiseMin(1);
  if (options_.silence.contains(t)) return;
  double delay = kTransmission + 0.001 * faults_.uniform();
  if (faults_.uniform() < options_.late) delay += kLateBy;
  const bool twice = faults_.uniform() < options_.duplicate;
  const std::string bytes = encode_packet(packet, options_.form);
  send(bytes, now_us + std::llround(delay * 1e6));
  if (twice) send(bytes, now_us + std::llround(2 * delay * 1e6));
}

void SimulatedDevice::emit_lines(std::int64_t now_us) {
  if (!started_ || options_.kind != SimulatedDeviceOptions::Kind::Line) return;
  const double step = 1 / options_.rate_hz;
  for (; next_sample_ * step <= seconds(now_us); ++next_sample_) {
    const double t = next_sample_ * step;
    if (options_.reboot_s >= 0 && t >= options_.reboot_s && !rebooted_) {
      rebooted_ = true;
      seq_ = 0;
      ticks_zero_m_ = wheel_distance(t);
      counting_since_us_ = start_us_ + std::llround(t * 1e6);
    }
    RawSample sample;
    measure(t, sample.accelerometer, sample.magnetometer, sample.gyroscope);
    // Its clock has been running since it was switched on, some seconds ago, and wraps in this second.
    const double running = t - static_cast<double>(counting_since_us_ - start_us_) * 1e-6;
    sample.t_us =
        static_cast<std::uint32_t>(std::llround((4294.0 + running * (1 + 1e-6 * options_.clock_ppm)) * 1e6));
    if (rebooted_) sample.t_us -= 4294000000U;
    const double ticks_per_m = MorphoriderPacket::kTicksPerTurn / options_.wheel_m;
    sample.ticks = static_cast<std::int32_t>(std::floor(wheel_distance(t) * ticks_per_m));
    sample.seq = seq_++;
    double delay = 0.002 + 0.003 * faults_.uniform();
    if (faults_.uniform() < options_.late) delay += kLateBy;
    const bool twice = faults_.uniform() < options_.duplicate;
    if (options_.silence.contains(t)) continue;
    std::int64_t due = start_us_ + std::llround((t + delay) * 1e6);
    if (options_.burst_s > 0) {
      const std::int64_t burst = std::llround(options_.burst_s * 1e6);
      due += burst - (due - start_us_) % burst;
    }
    send(format_line(sample) + "\n", due);
    if (twice) send(format_line(sample) + "\n", due + 1000);
    if (!options_.fused) continue;
    FusedSample fused;
    fused.seq = seq_++;
    fused.t_us = sample.t_us;
    fused.ticks = sample.ticks;
    fused.orientation = Eigen::Quaterniond(motion_.at(t).orientation *
                                           so3_exp(radians(0.3) * options_.noise * noise_.normal3()));
    fused.accuracy_rad = radians(1);
    send(format_line(fused) + "\n", due);
  }
}

std::string SimulatedDevice::transmit(std::int64_t now_us) {
  emit_lines(now_us);
  std::string bytes;
  while (!outgoing_.empty() && outgoing_.begin()->first <= now_us) {
    // What a device says while its plug is out is lost.
    if (plugged(outgoing_.begin()->first)) bytes += outgoing_.begin()->second;
    outgoing_.erase(outgoing_.begin());
  }
  return bytes;
}

std::int64_t SimulatedDevice::next_transmission_us(std::int64_t now_us) {
  emit_lines(now_us);
  std::int64_t next = outgoing_.empty() ? kNever : outgoing_.begin()->first;
  if (started_ && options_.kind == SimulatedDeviceOptions::Kind::Line) {
    const auto sample =
        static_cast<std::int64_t>(std::ceil(static_cast<double>(next_sample_) * 1e6 / options_.rate_hz));
    next = std::min(next, start_us_ + sample + 1);
  }
  return std::max(next, now_us + 1);
}

bool SimulatedDevice::plugged(std::int64_t now_us) const {
  return !started_ || !options_.unplug.contains(seconds(now_us));
}

bool SimulatedDevice::finished(std::int64_t now_us) const {
  return started_ && seconds(now_us) > motion_.duration();
}

std::vector<std::pair<std::int64_t, std::string>> SimulatedDevice::keys(std::int64_t now_us) {
  std::vector<std::pair<std::int64_t, std::string>> pressed;
  while (started_ && next_key_ < motion_.keys().size() &&
         motion_.keys()[next_key_].first <= seconds(now_us)) {
    const auto& [time, key] = motion_.keys()[next_key_++];
    pressed.emplace_back(start_us_ + std::llround(time * kMicroseconds), key);
  }
  return pressed;
}

}  // namespace batten
