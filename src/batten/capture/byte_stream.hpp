#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "batten/capture/clock.hpp"
#include "batten/core/error.hpp"

namespace batten {

/// The connection to a device is gone or nothing comes over it; opening it again may help.
class SourceLost : public Error {
  using Error::Error;
};

/// A way to and from a device.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// @throws SourceLost.
  virtual void write(std::string_view bytes) = 0;
  /// Bytes that have come; where none have, waits at most `seconds` of the host's clock for some.
  /// @throws SourceLost when the other side is gone.
  virtual std::string read(double seconds) = 0;
};

/// Opens a serial port for this program alone: 8 bits, no parity, one stop bit, no flow control.
/// @param baud one of those that serial ports have: 9600 … 921600.
/// @throws InvalidInput naming port, reason and remedy: not there, no permission, busy, no serial port.
std::unique_ptr<ByteStream> open_serial_port(const std::string& path, int baud, HostClock& clock);

/// Receives datagrams; answers go to where the last one came from.
/// @param address the network interface to listen at: "127.0.0.1" for this computer alone, "0.0.0.0" for all.
/// @throws InvalidInput where the port is taken or not allowed.
std::unique_ptr<ByteStream> open_udp(const std::string& address, int port, HostClock& clock);

/// Waits for one WebSocket client (RFC 6455) after the other; text frames become lines. Pages of other sites
/// than the one that is asked are refused (by their Origin), so that no web page can write a recording.
/// @throws InvalidInput as open_udp().
std::unique_ptr<ByteStream> open_web_socket(const std::string& address, int port, HostClock& clock);

}  // namespace batten
