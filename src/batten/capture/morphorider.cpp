#include "batten/capture/morphorider.hpp"

#include <algorithm>
#include <cmath>

#include "batten/capture/packet_limits_detail.hpp"
#include "batten/core/statistics.hpp"

namespace batten {

namespace {

constexpr double kFullScale = 32767;
using detail::kLargestIndexStep, detail::kLargestTicksPerPacket;
constexpr double kLengthTolerance = 0.2;
constexpr double kChangeTolerance = 0.3;
// A packet needs two of the five before it for witnesses. Where a fifth of all is spoilt, four of five are
// not: one packet in 150 has too few. More packets to look back at would let more of the spoilt find
// witnesses.
constexpr std::size_t kRecentPackets = 5;
constexpr int kWitnesses = 2;
// How far the best form must be ahead of the second for a decision, in points of 4.
constexpr double kSettlingMargin = 0.1;
constexpr std::size_t kFewestPackets = 10;

bool is_big_endian(PacketForm form) {
  return form == PacketForm::BigSignMagnitude || form == PacketForm::BigTwosComplement;
}
bool is_sign_magnitude(PacketForm form) {
  return form == PacketForm::BigSignMagnitude || form == PacketForm::LittleSignMagnitude;
}

unsigned word_at(std::string_view bytes, std::size_t at, PacketForm form) {
  const auto first = static_cast<unsigned char>(bytes[at]),
             second = static_cast<unsigned char>(bytes[at + 1]);
  return is_big_endian(form) ? first * 256U + second : second * 256U + first;
}

int signed_of(unsigned word, PacketForm form) {
  const auto magnitude = static_cast<int>(word & 0x7fffU);
  if (is_sign_magnitude(form)) return (word & 0x8000U) != 0 ? -magnitude : magnitude;
  return (word & 0x8000U) != 0 ? magnitude - 0x8000 : magnitude;
}

void put_word(std::string& bytes, unsigned word, PacketForm form) {
  const char high = static_cast<char>(word >> 8 & 255U), low = static_cast<char>(word & 255U);
  bytes += is_big_endian(form) ? high : low;
  bytes += is_big_endian(form) ? low : high;
}

unsigned word_of_signed(int value, PacketForm form) {
  value = std::clamp(value, -32767, 32767);
  if (value >= 0) return static_cast<unsigned>(value);
  return is_sign_magnitude(form) ? 0x8000U | static_cast<unsigned>(-value)
                                 : static_cast<unsigned>(value + 0x10000);
}

/// How well a sequence of packets hangs together: four shares, of pairs or packets.
double score(const std::vector<MorphoriderPacket>& packets) {
  std::vector<double> acc, mag;
  for (const MorphoriderPacket& p : packets) {
    acc.push_back(p.accelerometer.norm());
    mag.push_back(p.magnetometer.norm());
  }
  const double acc_length = std::max(upper_median(acc), 1e-6), mag_length = std::max(upper_median(mag), 1e-6);
  double steps = 0, small = 0, lengths = 0, continuity = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const MorphoriderPacket& p = packets[i];
    if (std::abs(p.small) < MorphoriderPacket::kTicksPerTurn) ++small;
    if (std::abs(p.accelerometer.norm() / acc_length - 1) < kLengthTolerance) lengths += 0.5;
    if (std::abs(p.magnetometer.norm() / mag_length - 1) < kLengthTolerance) lengths += 0.5;
    if (i == 0) continue;
    const MorphoriderPacket& q = packets[i - 1];
    const int step = index_step(q.index, p.index);
    if (step >= 1 && step <= kLargestIndexStep &&
        std::abs(p.ticks() - q.ticks()) <= kLargestTicksPerPacket * step)
      ++steps;
    if ((p.accelerometer - q.accelerometer).norm() < kChangeTolerance * acc_length) continuity += 0.5;
    if ((p.magnetometer - q.magnetometer).norm() < kChangeTolerance * mag_length) continuity += 0.5;
  }
  const auto n = static_cast<double>(packets.size());
  return (small + lengths) / n + (steps + continuity) / std::max(n - 1, 1.0);
}

}  // namespace

MorphoriderPacket decode_packet(std::string_view bytes, PacketForm form) {
  MorphoriderPacket packet;
  for (std::size_t i = 0; i < 4; ++i) packet.control[i] = static_cast<std::uint8_t>(bytes[i]);
  packet.index = static_cast<std::uint16_t>(word_at(bytes, 4, form));
  packet.big = signed_of(word_at(bytes, 6, form), form);
  packet.small = signed_of(word_at(bytes, 8, form), form);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    packet.accelerometer[axis] = signed_of(word_at(bytes, 10 + 2 * k, form), form) / kFullScale;
    packet.magnetometer[axis] = signed_of(word_at(bytes, 16 + 2 * k, form), form) / kFullScale;
  }
  return packet;
}

std::string encode_packet(const MorphoriderPacket& packet, PacketForm form) {
  std::string bytes;
  for (const std::uint8_t byte : packet.control) bytes += static_cast<char>(byte);
  put_word(bytes, packet.index, form);
  put_word(bytes, word_of_signed(packet.big, form), form);
  put_word(bytes, word_of_signed(packet.small, form), form);
  for (const Eigen::Vector3d* v : {&packet.accelerometer, &packet.magnetometer})
    for (const double x : *v)
      put_word(bytes, word_of_signed(static_cast<int>(std::lround(x * kFullScale)), form), form);
  return bytes;
}

int index_step(std::uint16_t from, std::uint16_t to) {
  const int step = (static_cast<int>(to) - static_cast<int>(from)) & 0xffff;
  // The wrap of 15 bits: from shortly before 32768 to shortly after 0.
  const int short_step = static_cast<int>(to) - static_cast<int>(from) + 0x8000;
  return from < 0x8000 && to < 0x8000 && to < from && short_step < step ? short_step : step;
}

FormRecognition recognise_form(const std::vector<std::string>& packets) {
  FormRecognition result;
  std::size_t n = 0;
  for (std::size_t f = 0; f < 4; ++f) {
    std::vector<MorphoriderPacket> decoded;
    for (const std::string& bytes : packets)
      if (bytes.size() == MorphoriderPacket::kBytes)
        decoded.push_back(decode_packet(bytes, static_cast<PacketForm>(f)));
    n = decoded.size();
    if (n > 0) result.scores[f] = score(decoded);
  }
  std::size_t best = 0;
  for (std::size_t f = 1; f < 4; ++f)
    if (result.scores[f] > result.scores[best] + 1e-12) best = f;
  double second = 0;
  for (std::size_t f = 0; f < 4; ++f)
    if (f != best) second = std::max(second, result.scores[f]);
  result.form = static_cast<PacketForm>(best);
  result.settled = n >= kFewestPackets && result.scores[best] - second > kSettlingMargin;
  return result;
}

bool PacketGate::agrees(const MorphoriderPacket& from, const MorphoriderPacket& to, int between) const {
  const int step = index_step(from.index, to.index);
  if (to.control != from.control || step < 1 || step > kLargestIndexStep + between) return false;
  if (std::abs(to.small) >= MorphoriderPacket::kTicksPerTurn) return false;
  if (std::abs(to.ticks() - from.ticks()) > kLargestTicksPerPacket * step) return false;
  const double spread = kChangeTolerance * std::sqrt(1.0 + between);
  return (to.accelerometer - from.accelerometer).norm() < spread * from.accelerometer.norm() &&
         (to.magnetometer - from.magnetometer).norm() < spread * from.magnetometer.norm();
}

PacketGate::Verdict PacketGate::judge(const MorphoriderPacket& packet) {
  const double acc = packet.accelerometer.norm(), mag = packet.magnetometer.norm();
  const bool usual = believed_ && std::abs(acc / accelerometer_length_ - 1) < kLengthTolerance &&
                     std::abs(mag / magnetometer_length_ - 1) < kLengthTolerance;
  int agreeing = 0, in_a_row = 0;
  bool goes_on = false;
  for (std::size_t back = 0; back < recent_.size(); ++back) {
    const auto& [other, believed] = recent_[recent_.size() - 1 - back];
    if (!agrees(other, packet, static_cast<int>(back))) continue;
    ++agreeing;
    goes_on = goes_on || believed;
    if (in_a_row == static_cast<int>(back)) ++in_a_row;
  }
  const bool is_new = !believed_ || index_step(believed_->index, packet.index) != 0;
  const bool is_believed = is_new && agreeing >= kWitnesses && (usual || in_a_row >= kWitnesses);
  recent_.emplace_back(packet, is_believed);
  if (recent_.size() > kRecentPackets) recent_.pop_front();
  ++refused_since_;
  if (!is_believed) return Verdict::Refused;
  goes_on = goes_on || !believed_ ||
            (index_step(believed_->index, packet.index) <= kLargestIndexStep + refused_since_ &&
             std::abs(packet.ticks() - believed_->ticks()) <= kLargestTicksPerPacket * refused_since_);
  // The usual lengths follow slowly: a device that is not calibrated has other lengths in other directions.
  const double share = usual ? 0.05 : 1;
  accelerometer_length_ += share * (acc - accelerometer_length_);
  magnetometer_length_ += share * (mag - magnetometer_length_);
  believed_ = packet;
  refused_since_ = 0;
  return goes_on ? Verdict::Good : Verdict::Restarted;
}

}  // namespace batten
