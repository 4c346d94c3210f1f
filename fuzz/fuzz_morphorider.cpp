#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "batten/capture/morphorider.hpp"

/// Any bytes as packets, with times of which the first bytes decide.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using batten::MorphoriderPacket;
  std::vector<std::string> packets;
  std::vector<std::int64_t> times;
  std::int64_t time = 0;
  for (std::size_t at = 1; at + MorphoriderPacket::kBytes <= size && packets.size() < 400;
       at += MorphoriderPacket::kBytes) {
    packets.emplace_back(data + at, data + at + MorphoriderPacket::kBytes);
    times.push_back(time);
    time += data[0] < 128 ? 10000 : data[at] * std::int64_t{1000};
  }
  const batten::FormRecognition found = batten::recognise_form(packets);
  batten::PacketGate gate;
  for (const std::string& bytes : packets) {
    const MorphoriderPacket packet = batten::decode_packet(bytes, found.form);
    gate.judge(packet);
    const MorphoriderPacket again =
        batten::decode_packet(batten::encode_packet(packet, found.form), found.form);
    if (again.index != packet.index || again.control != packet.control) std::abort();
  }
  const batten::PacketDecision decision = batten::decide_packets(packets, times, found.form);
  if (decision.fate.size() != packets.size()) std::abort();
  std::int64_t last = -1;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (decision.fate[i] != batten::PacketDecision::Fate::Kept) continue;
    if (decision.index[i] < last) std::abort();
    last = decision.index[i];
  }
  return 0;
}
