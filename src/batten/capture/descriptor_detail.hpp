#pragma once
#include "batten/capture/clock.hpp"

// Private to the room.
namespace batten::detail {

/// Waits for something to happen at an open file, at most `seconds` of the clock. False where nothing did.
/// @param events as poll(2) names them.
bool wait_for(int descriptor, short events, double seconds, HostClock& clock);

}  // namespace batten::detail
