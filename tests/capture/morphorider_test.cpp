#include "batten/capture/morphorider.hpp"

#include "capture/simulated.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten::test {
namespace {

struct Packets {
  std::vector<std::string> bytes;
  std::vector<std::int64_t> times;
};

Packets packets_of(const std::string& source) {
  Packets packets;
  for (const CaptureEvent& event : captured(source).recording.events)
    if (event.kind == EventKind::Packet && event.payload.size() == MorphoriderPacket::kBytes) {
      packets.bytes.push_back(event.payload);
      packets.times.push_back(event.time_us);
    }
  return packets;
}

/// Whether values that are wrong enough to matter came through: any error of the ticks, 2 degrees of a
/// vector.
bool is_wrong(const MorphoriderPacket& truth, const MorphoriderPacket& got) {
  const auto angle = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
  };
  return truth.ticks() != got.ticks() || angle(truth.accelerometer, got.accelerometer) > radians(2) ||
         angle(truth.magnetometer, got.magnetometer) > radians(2);
}

struct Quality {
  double wrong_kept = 0, good_lost = 0;  // shares of all packets, of the good ones
};

/// The same motion with and without turned bits: what is decided about the one, judged by the other.
Quality quality(const std::string& source, const std::string& faults) {
  const Packets clean = packets_of(source), spoilt = packets_of(source + faults);
  EXPECT_EQ(clean.bytes.size(), spoilt.bytes.size());
  const PacketForm form = PacketForm::BigSignMagnitude;
  const PacketDecision decision = decide_packets(spoilt.bytes, spoilt.times, form);
  double good = 0, lost = 0, wrong = 0;
  for (std::size_t i = 0; i < clean.bytes.size(); ++i) {
    const bool kept = decision.fate[i] == PacketDecision::Fate::Kept;
    if (clean.bytes[i] == spoilt.bytes[i]) {
      ++good;
      lost += kept ? 0 : 1;
    } else if (kept && is_wrong(decode_packet(clean.bytes[i], form), decode_packet(spoilt.bytes[i], form))) {
      ++wrong;
    }
  }
  return {wrong / static_cast<double>(clean.bytes.size()), lost / good};
}

// Tested on motions that the limits of the decision were not chosen on.
TEST(DecidePackets, KeepsFewWrongPacketsAndLosesFewGoodOnes) {
  for (const char* source :
       {"simulator:cone?speed=max&tumble=1&seed=11", "simulator:dish?speed=max&pace=6&seed=12"}) {
    const Quality q = quality(source, "&flip=1%");
    EXPECT_LE(q.wrong_kept, 0.002) << source;
    EXPECT_LE(q.good_lost, 0.02) << source;
  }
}

TEST(DecidePackets, KeepsNearlyAllOfACleanStreamAndNoPacketTwice) {
  const Packets packets = packets_of("simulator:sphere?speed=max&duplicate=5%&late=2%&seed=2");
  const PacketDecision decision = decide_packets(packets.bytes, packets.times, PacketForm::BigSignMagnitude);
  std::int64_t last = -1;
  double kept = 0;
  for (std::size_t i = 0; i < packets.bytes.size(); ++i) {
    if (decision.fate[i] != PacketDecision::Fate::Kept) continue;
    EXPECT_GT(decision.index[i], last);
    last = decision.index[i];
    ++kept;
  }
  EXPECT_GT(kept, 0.97 * static_cast<double>(packets.bytes.size()));
}

// The count of packets wraps after five minutes, that of ticks must not notice.
TEST(DecidePackets, CountsOnOverWrapAndRestartOfTheIndex) {
  const Packets packets = packets_of("simulator:sphere?speed=max&restart=20&noise=0.1");
  const PacketDecision decision = decide_packets(packets.bytes, packets.times, PacketForm::BigSignMagnitude);
  EXPECT_EQ(decision.n_restarts, 1);
  for (const bool lost : decision.distance_lost_before) {
    EXPECT_FALSE(lost);
  }
}

TEST(DecidePackets, TellsWhereADeviceLostItsCount) {
  const Packets packets = packets_of("simulator:sphere?speed=max&reboot=25&noise=0.1");
  const PacketDecision decision = decide_packets(packets.bytes, packets.times, PacketForm::BigSignMagnitude);
  EXPECT_EQ(std::count(decision.distance_lost_before.begin(), decision.distance_lost_before.end(), true), 1);
}

TEST(DecodePacket, ReadsBackEveryForm) {
  MorphoriderPacket packet;
  packet.control = {1, 2, 3, 4};
  packet.index = 32700;
  packet.big = -3;
  packet.small = 499;
  packet.accelerometer = Eigen::Vector3d(12345, -1, 0) / 32767;
  packet.magnetometer = Eigen::Vector3d(-32767, 32767, 256) / 32767;
  for (const PacketForm form : choice_values<PacketForm>()) {
    const std::string bytes = encode_packet(packet, form);
    ASSERT_EQ(bytes.size(), MorphoriderPacket::kBytes);
    const MorphoriderPacket read = decode_packet(bytes, form);
    EXPECT_EQ(read.control, packet.control);
    EXPECT_EQ(read.index, packet.index);
    EXPECT_EQ(read.ticks(), -3 * 500 + 499);
    EXPECT_NEAR((read.accelerometer - packet.accelerometer).norm(), 0, 1e-12);
    EXPECT_NEAR((read.magnetometer - packet.magnetometer).norm(), 0, 1e-12);
  }
}

// By hand: -1 is 0x8001 with a sign, 0xffff in two's complement; the low byte comes first or second.
TEST(DecodePacket, KnowsTheFourWaysToWriteMinusOne) {
  const auto minus_one = [](PacketForm form) {
    MorphoriderPacket packet;
    packet.big = -1;
    return encode_packet(packet, form).substr(6, 2);
  };
  EXPECT_EQ(minus_one(PacketForm::BigSignMagnitude), "\x80\x01");
  EXPECT_EQ(minus_one(PacketForm::LittleSignMagnitude), "\x01\x80");
  EXPECT_EQ(minus_one(PacketForm::BigTwosComplement), "\xff\xff");
  EXPECT_EQ(minus_one(PacketForm::LittleTwosComplement), "\xff\xff");
}

TEST(IndexStep, CountsAcrossBothWraps) {
  EXPECT_EQ(index_step(5, 6), 1);
  EXPECT_EQ(index_step(32767, 0), 1);
  EXPECT_EQ(index_step(65535, 0), 1);
  EXPECT_EQ(index_step(32766, 3), 5);
  EXPECT_EQ(index_step(32767, 32768), 1);
}

// Ten packets during a turn in which some number changes its sign: without, nothing tells the forms apart.
TEST(RecogniseForm, SettlesOnTenPacketsOfATumble) {
  for (const char* form : {"be-sm", "be-tc", "le-sm", "le-tc"}) {
    const Packets all = packets_of(std::string("simulator:sphere?speed=max&tumble=1&seed=5&form=") + form);
    int trials = 0;
    for (std::size_t begin = 500; begin + 100 < 6000; begin += 50) {
      std::vector<std::string> ten;
      std::vector<MorphoriderPacket> decoded;
      for (std::size_t k = 0; k < 10; ++k) {
        ten.push_back(all.bytes[begin + 8 * k]);
        decoded.push_back(decode_packet(ten.back(), parse_choice<PacketForm>(form)));
      }
      int changes = 0;
      for (std::size_t k = 1; k < 10; ++k)
        changes +=
            (decoded[k].accelerometer.cwiseProduct(decoded[k - 1].accelerometer).minCoeff() < 0 ? 1 : 0) +
            (decoded[k].magnetometer.cwiseProduct(decoded[k - 1].magnetometer).minCoeff() < 0 ? 1 : 0);
      if (changes < 2) continue;
      ++trials;
      EXPECT_EQ(word_of(recognise_form(ten).form), form) << begin;
    }
    EXPECT_GT(trials, 20);
    EXPECT_TRUE(recognise_form({all.bytes.begin() + 500, all.bytes.begin() + 3000}).settled) << form;
  }
}

TEST(RecogniseForm, IsNotSettledWithoutPackets) {
  EXPECT_FALSE(recognise_form({}).settled);
  EXPECT_FALSE(recognise_form({"short"}).settled);
}

// One wrong packet that was believed must not keep out all later ones.
TEST(PacketGate, TakesUpAStreamAnewAfterThreePacketsThatAgree) {
  PacketGate gate;
  MorphoriderPacket packet;
  packet.accelerometer = {0, 0, 0.5};
  packet.magnetometer = {0.3, 0, -0.2};
  long good = 0;
  for (int i = 0; i < 50; ++i) {
    packet.index = static_cast<std::uint16_t>(i);
    packet.small = i;
    if (i == 20) packet.big = 7;  // and stays: as if the reference before had been wrong
    const PacketGate::Verdict verdict = gate.judge(packet);
    if (i > 3 && i != 20 && i != 21 && i != 22) {
      EXPECT_NE(verdict, PacketGate::Verdict::Refused) << i;
    }
    if (i == 22) {
      EXPECT_EQ(verdict, PacketGate::Verdict::Restarted);
    }
    good += verdict != PacketGate::Verdict::Refused ? 1 : 0;
  }
  EXPECT_EQ(good, 46);
}

}  // namespace
}  // namespace batten::test
