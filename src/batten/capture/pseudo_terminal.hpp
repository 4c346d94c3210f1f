#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "batten/capture/byte_stream.hpp"
#include "batten/capture/simulated_device.hpp"

namespace batten {

/// A simulated device behind a pseudo-terminal, served by a thread of its own: to the program that opens it,
/// a serial port like any other. While it is unplugged the port is gone.
class PseudoTerminal {
 public:
  /// @param clock of both sides; outlives this object. @throws InvalidInput where the system has no
  /// pseudo-terminals left.
  PseudoTerminal(SimulatedDevice device, HostClock& clock);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  /// The port, the same before and after it was unplugged.
  const std::string& path() const;
  /// Keys pressed by now and not fetched before (SimulatedDevice::keys()).
  std::vector<std::pair<std::int64_t, std::string>> keys();
  bool finished() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// A simulated device without a terminal, whose clock passes while one waits for it: the same bytes at the
/// same times every run. The device outlives the stream, and may be connected anew.
/// @throws InvalidInput while it is unplugged.
std::unique_ptr<ByteStream> connect_directly(SimulatedDevice& device, VirtualClock& clock);

}  // namespace batten
