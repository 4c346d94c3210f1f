#pragma once
#include <string>
#include <utility>
#include <vector>

// Which sources a page may open: those of `batten capture`, without the reach that a command line has.
namespace batten::studio {

/// Sources that there are, each with a word on it: simulators first, then serial ports, then the network.
std::vector<std::pair<std::string, std::string>> offered_sources();

/// @throws InvalidInput with the remedy, where a page may not open the source: other files than serial ports
/// that were found, simulated motions from files, addresses of the network. Recordings are opened by number.
void check_offered(const std::string& source);

}  // namespace batten::studio
