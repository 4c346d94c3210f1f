#pragma once

namespace batten::detail {

/// Limits of the causal checks of packets; their source is the header of PacketGate.
constexpr int kLargestIndexStep = 20;
constexpr int kLargestTicksPerPacket = 60;

}  // namespace batten::detail
