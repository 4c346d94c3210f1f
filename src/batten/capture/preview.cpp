#include "batten/capture/preview.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/capture/decode.hpp"
#include "batten/core/error.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/rotation/wahba.hpp"
#include "batten/scan/integration.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::int64_t kRateWindow = 2000000, kGap = 500000;  // microseconds
constexpr std::size_t kMostTimes = 2500;                      // of the rate window, at any rate
constexpr std::size_t kMostFirstPackets = 320;
constexpr double kUsualWheel = 0.0628;
// The dip of the field is the mean of the last so many readings.
constexpr long kDipReadings = 500;
// Wider than this no step between two readings is: a device that counts anew (metres).
constexpr double kWidestStep = 1;

}  // namespace

LivePreview::LivePreview(const RecordingHeader& header) : header_(header), keys_(header.n_nodes) {
  if (header.calibration) calibration_ = parse_calibration(*header.calibration, "the calibration");
  if (header.form) form_ = parse_choice<PacketForm>(*header.form);
  if (header.axes) axes_ = *header.axes;
}

bool LivePreview::push(const CaptureEvent& event) {
  state_.time_us = event.time_us;
  for (const Mark& mark : keys_.wait(event.time_us)) apply(mark);
  bool changed = true;
  switch (event.kind) {
    case EventKind::Packet:
      changed = take_packet(event);
      break;
    case EventKind::Line:
      changed = take_line(event);
      break;
    case EventKind::Key:
      take_key(event.time_us, event.payload);
      break;
    case EventKind::State:
      state_.source = event.payload;
      break;
  }
  state_.digits = keys_.pending();
  return changed;
}

/// The form is looked for in the first packets: at 10, 20, 40, … of them, until it is clear.
void LivePreview::settle_form(const std::string& packet) {
  if (first_packets_.size() >= kMostFirstPackets) return;
  first_packets_.push_back(packet);
  const std::size_t n = first_packets_.size();
  if (n < 10 || (n & (n - 1)) != 0) {
    if (n != 10) return;
  }
  const FormRecognition found = recognise_form(first_packets_);
  if (!form_ || *form_ != found.form) {
    form_ = found.form;
    gate_ = PacketGate();
  }
  if (found.settled) first_packets_.assign(kMostFirstPackets, {});  // enough is known
}

bool LivePreview::take_packet(const CaptureEvent& event) {
  if (event.payload.size() != MorphoriderPacket::kBytes) {
    ++state_.n_refused;
    return true;
  }
  if (!header_.form) settle_form(event.payload);
  const MorphoriderPacket packet = decode_packet(event.payload, form_.value_or(PacketForm::BigSignMagnitude));
  const PacketGate::Verdict verdict = gate_.judge(packet);
  if (verdict == PacketGate::Verdict::Refused) {
    ++state_.n_refused;
    ++refused_since_;
    return true;
  }
  if (verdict == PacketGate::Verdict::Restarted) {
    last_distance_.reset();
  } else if (last_index_) {
    const int step = index_step(*last_index_, packet.index);
    if (step > 1 && step < 1000) state_.n_missing += std::max(0, step - 1 - refused_since_);
  }
  last_index_ = packet.index;
  refused_since_ = 0;
  Sample sample;
  sample.time_us = event.time_us;
  sample.distance = static_cast<double>(packet.ticks()) / MorphoriderPacket::kTicksPerTurn *
                    header_.wheel_m.value_or(kUsualWheel);
  sample.accelerometer = packet.accelerometer;
  sample.magnetometer = packet.magnetometer;
  if (calibration_) {  // made in the units of decoded logs
    const DecodeOptions ranges;
    sample.accelerometer *= ranges.accelerometer_range;
    sample.magnetometer *= ranges.magnetometer_range;
  }
  count_time(event.time_us);
  move(sample);
  return true;
}

bool LivePreview::take_line(const CaptureEvent& event) {
  LineMessage message;
  try {
    message = parse_line(event.payload, device_.checked);
  } catch (const InvalidInput&) {
    ++state_.n_refused;
    return true;
  }
  if (const auto* header = std::get_if<DeviceHeader>(&message)) {
    device_ = *header;
    if (device_.axes && !header_.axes) axes_ = *device_.axes;
    return true;
  }
  if (const auto* press = std::get_if<ButtonPress>(&message)) {
    take_key(event.time_us, press->key);
    return true;
  }
  Sample sample;
  std::uint32_t seq = 0, t_us = 0;
  std::optional<std::int32_t> ticks;
  if (const auto* raw = std::get_if<RawSample>(&message)) {
    if (device_orients_) return false;  // its fused samples lead
    sample.accelerometer = raw->accelerometer;
    sample.magnetometer = raw->magnetometer;
    std::tie(seq, t_us, ticks) = std::tuple(raw->seq, raw->t_us, raw->ticks);
  } else if (const auto* fused = std::get_if<FusedSample>(&message)) {
    if (calibration_) return false;
    device_orients_ = true;
    sample.orientation = fused->orientation.toRotationMatrix();
    std::tie(seq, t_us, ticks) = std::tuple(fused->seq, fused->t_us, fused->ticks);
  } else {
    return false;
  }
  if (last_seq_) {
    const std::uint32_t step = seq - *last_seq_;
    // Two kinds of lines may share one count.
    if (step > 2 && step < 1000) state_.n_missing += step - 1;
  }
  last_seq_ = seq;
  sample.time_us = clock_.host_us(unwrap_time_(t_us), event.time_us);
  if (ticks && device_.ticks_per_m > 0)
    sample.distance =
        static_cast<double>(unwrap_ticks_(static_cast<std::uint32_t>(*ticks))) / device_.ticks_per_m;
  count_time(event.time_us);
  move(sample);
  return true;
}

void LivePreview::count_time(std::int64_t time_us) {
  ++state_.n_readings;
  if (!times_.empty() && time_us - times_.back() > kGap) ++state_.n_gaps;
  times_.push_back(time_us);
  while (times_.size() > kMostTimes || times_.front() < time_us - kRateWindow) times_.pop_front();
  const auto n = static_cast<double>(times_.size()) - 1;
  if (n < 1) return;
  const double span = static_cast<double>(times_.back() - times_.front()) * 1e-6;
  state_.rate_hz = span > 0 ? n / span : 0;
  double squares = 0;
  for (std::size_t i = 1; i < times_.size(); ++i) {
    const double step = static_cast<double>(times_[i] - times_[i - 1]) * 1e-6 - span / n;
    squares += step * step;
  }
  state_.jitter_s = std::sqrt(squares / n);
}

std::optional<Matrix3d> LivePreview::orientation_of(const Sample& sample) {
  if (sample.orientation) return *sample.orientation * axes_.matrix();
  Vector3d acc = sample.accelerometer, mag = sample.magnetometer;
  if (calibration_) {
    acc = calibration_->accelerometer.apply(acc);
    mag = calibration_->magnetometer.apply(mag);
  }
  if (!(acc.norm() > 1e-9) || !(mag.norm() > 1e-9)) return std::nullopt;
  n_dips_ = std::min(n_dips_ + 1, kDipReadings);
  sine_of_dip_ += (-acc.normalized().dot(mag.normalized()) - sine_of_dip_) / static_cast<double>(n_dips_);
  const double sine = std::clamp(sine_of_dip_, -0.999, 0.999);
  try {
    return solve_wahba(
               {{Vector3d(0, 0, 1), acc, 1}, {Vector3d(std::sqrt(1 - sine * sine), 0, -sine), mag, 1}}) *
           axes_.matrix();
  } catch (const InvalidInput&) {
    return std::nullopt;  // both vectors are parallel: one of them is wrong
  }
}

void LivePreview::move(const Sample& sample) {
  const std::optional<Matrix3d> frame = orientation_of(sample);
  double way = 0;
  if (sample.distance && last_distance_) {
    const double change = *sample.distance - *last_distance_;
    if (std::abs(change) < kWidestStep) {
      turned_ += change;
      way = std::max(0.0, turned_ < 0 ? -change : change);
    }
  }
  if (sample.distance) last_distance_ = sample.distance;
  if (!frame) return;
  if (last_frame_ && way > 0 && book_.current() != nullptr && !book_.paused()) {
    state_.position += frame_step(*last_frame_, *frame, way, StepRule::ConstantRate);
    state_.distance_m += way;
  }
  state_.frame = *frame;
  last_frame_ = frame;
}

void LivePreview::take_key(std::int64_t time_us, std::string_view key) {
  for (const Mark& mark : keys_.press(time_us, key)) apply(mark);
}

void LivePreview::meet_node(int node) {
  const double way = state_.distance_m - way_at_node_;
  way_at_node_ = state_.distance_m;
  if (node == Mark::kUnnumbered) return;
  const auto known = places_.find(node);
  if (known == places_.end()) {
    if (places_.empty() && !met_node_) {  // the first of all is the origin
      state_.position.setZero();
      state_.placed = true;
    }
    (state_.placed ? places_ : places_in_curve_)[node] = state_.position;
    new_nodes_.push_back(node);
  } else {
    if (state_.placed) {
      state_.drift_m = (state_.position - known->second).norm();
      state_.drift_way_m = way;
      state_.drift_node = node;
    }
    for (const auto& [other, place] : places_in_curve_)
      places_[other] = place + known->second - state_.position;
    places_in_curve_.clear();
    state_.position = known->second;
    state_.placed = true;
  }
  met_node_ = true;
  state_.n_nodes = static_cast<int>(places_.size());
}

void LivePreview::apply(const Mark& mark) {
  book_.apply(mark);
  const auto forget = [this](int node) {
    places_.erase(node);
    places_in_curve_.erase(node);
  };
  switch (mark.kind) {
    case MarkKind::Inner:
    case MarkKind::Boundary:
      places_in_curve_.clear();
      new_nodes_.clear();
      state_.distance_m = way_at_node_ = 0;
      state_.position.setZero();
      state_.placed = met_node_ = false;
      break;
    case MarkKind::Node:
    case MarkKind::Number:
      if (book_.current() != nullptr) meet_node(mark.node);
      break;
    case MarkKind::Undo:
      if (!new_nodes_.empty()) {
        forget(new_nodes_.back());
        new_nodes_.pop_back();
      }
      break;
    case MarkKind::Discard:
      for (const int node : new_nodes_) forget(node);
      new_nodes_.clear();
      break;
    default:
      break;
  }
  state_.n_curves = static_cast<int>(book_.curves().size());
  state_.drawing = book_.current() != nullptr;
  state_.paused = book_.paused();
  state_.n_nodes = static_cast<int>(places_.size());
}

}  // namespace batten
