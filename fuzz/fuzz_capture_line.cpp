#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/capture/line_protocol.hpp"
#include "batten/capture/web_socket.hpp"
#include "batten/core/error.hpp"

namespace {

/// What is read and written again is read as the same.
void check_round(const batten::LineMessage& message) {
  const std::string line = batten::format_line(message);
  if (line.size() > batten::kLongestLine) return;  // numbers may be written longer than they were read
  const bool is_complaint = std::holds_alternative<batten::DeviceComplaint>(message);
  if (!is_complaint && batten::format_line(batten::parse_line(line)) != line) std::abort();
}

}  // namespace

/// Any bytes as lines of the line protocol, as a handshake and as frames of a WebSocket.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(data, data + size);
  batten::LineSplitter splitter;
  for (const std::string& line : splitter.push(bytes)) {
    if (line.size() > batten::kLongestLine) std::abort();
    for (const bool checked : {true, false}) {
      try {
        check_round(batten::parse_line(line, checked));
      } catch (const batten::InvalidInput&) {
        // No line of the protocol.
      }
    }
  }
  batten::answer_handshake(bytes);
  batten::WebSocketFrames frames;
  try {
    frames.push(bytes);
  } catch (const batten::InvalidInput&) {
    // No frames.
  }
  return 0;
}
