#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/choices.hpp"

namespace batten {

/// How the numbers of a Morphorider packet are written. S 5.2.1 says "16-bit signed integers, first bit
/// represents the sign", which leaves the order of the bytes and the form of negative numbers open.
enum class PacketForm {
  BigSignMagnitude,     ///< high byte first, a sign and 15 bits: what the text suggests
  BigTwosComplement,    ///< high byte first, two's complement
  LittleSignMagnitude,  ///< low byte first, a sign and 15 bits
  LittleTwosComplement  ///< low byte first, two's complement
};

constexpr auto choices_of(PacketForm) {
  return choices<PacketForm>("form of packets", {{PacketForm::BigSignMagnitude, "be-sm"},
                                                 {PacketForm::BigTwosComplement, "be-tc"},
                                                 {PacketForm::LittleSignMagnitude, "le-sm"},
                                                 {PacketForm::LittleTwosComplement, "le-tc"}});
}

/// The answer of a Morphorider to the byte 'Q' (S 5.2.1).
struct MorphoriderPacket {
  static constexpr std::size_t kBytes = 22;
  static constexpr char kRequest = 'Q';
  static constexpr int kTicksPerTurn = 500;

  std::array<std::uint8_t, 4> control{};   ///< of unknown meaning
  std::uint16_t index = 0;                 ///< counts packets; wraps from 32767 or 65535 to 0
  int big = 0;                             ///< turns of the wheel
  int small = 0;                           ///< five-hundredths of a turn
  Eigen::Vector3d accelerometer{0, 0, 0};  ///< device axes, in full scales, [−1, 1]
  Eigen::Vector3d magnetometer{0, 0, 0};

  int ticks() const { return big * kTicksPerTurn + small; }
};

/// @pre bytes.size() == MorphoriderPacket::kBytes.
MorphoriderPacket decode_packet(std::string_view bytes, PacketForm form);
/// The inverse, for simulators; vectors are rounded to 15 bits.
std::string encode_packet(const MorphoriderPacket& packet, PacketForm form);

/// From one index to the next, 0 … 65535, across either wrap.
int index_step(std::uint16_t from, std::uint16_t to);

/// Which form packets have.
struct FormRecognition {
  PacketForm form = PacketForm::BigSignMagnitude;
  std::array<double, 4> scores{};  ///< by form, 0 … 4
  bool settled = false;  ///< the best is ahead by far; a device at rest does not show the form of negatives
};

/// Decodes packets in all four ways and takes the one in which neighbours fit best: indices that count up,
/// small ticks below 500, vectors of constant length and without jumps (docs/capture.md#morphorider). Ten
/// packets of a device in motion settle it; packets of other lengths do not count.
FormRecognition recognise_form(const std::vector<std::string>& packets);

/// Decides packet by packet, as they come, which to believe: for the live view.
///
/// Two packets agree where their control bytes are equal, the index goes on by 1 … 20, ticks change by at
/// most 60 per packet, and no vector by more than 0.3 of its length. A packet is believed that agrees with
/// two of the five before it, believed or not, and whose vectors differ from their usual length by at most 20
/// %: a wrong packet that was believed keeps out none of the later ones. Two packets and a third that follow
/// each other and agree set the usual lengths anew.
class PacketGate {
 public:
  enum class Verdict { Good, Refused, Restarted };

  /// Restarted: believed, but indices or ticks do not continue those of before.
  Verdict judge(const MorphoriderPacket& packet);

 private:
  bool agrees(const MorphoriderPacket& from, const MorphoriderPacket& to, int packets_between) const;

  std::deque<std::pair<MorphoriderPacket, bool>> recent_;  ///< the last of all, and which are believed
  std::optional<MorphoriderPacket> believed_;              ///< the last that is
  int refused_since_ = 0;
  double accelerometer_length_ = 0, magnetometer_length_ = 0;
};

/// What to believe of a whole recording, decided with neighbours on both sides.
struct PacketDecision {
  enum class Fate : std::uint8_t { Kept, Refused, Duplicate };
  std::vector<Fate> fate;                  ///< n
  std::vector<std::int64_t> ticks;         ///< n, without jumps of restarts; of kept packets
  std::vector<std::int64_t> index;         ///< n, counted on over wraps and restarts; of kept packets
  std::vector<bool> distance_lost_before;  ///< n: the wheel may have turned uncounted since the last kept one
  long n_restarts = 0;
};

/// @param packets n packets of MorphoriderPacket::kBytes bytes. @param time_us when each was asked for.
/// A packet is kept where all of it agrees with its neighbours: constant control bytes and index exactly,
/// ticks within 1.5 (or 4.5 times their usual deviation) of a cubic through two believed neighbours on each
/// side, vectors within 4.5 deviations of a line through three. Which packets are believed is found by taking
/// out the worst again and again, and by looking at each of them once more at the end. O(n).
PacketDecision decide_packets(const std::vector<std::string>& packets,
                              const std::vector<std::int64_t>& time_us, PacketForm form);

}  // namespace batten
