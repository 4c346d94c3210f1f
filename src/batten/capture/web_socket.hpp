#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace batten {

// The server's half of WebSocket (RFC 6455), as far as text lines need it, without any input or output.

/// The answer to the request with which a browser opens a WebSocket, up to and with its empty line.
struct WebSocketHandshake {
  bool accepted = false;
  std::string answer;   ///< to be sent in any case
  std::string problem;  ///< in words where it is not accepted
};

/// @param request complete: it ends with an empty line. Origins other than the host that is asked, this
/// computer or none are refused.
WebSocketHandshake answer_handshake(std::string_view request);

/// What the server sends: one text frame, at most 65535 bytes.
std::string text_frame(std::string_view text);

/// Takes a client's stream of bytes apart.
class WebSocketFrames {
 public:
  /// @return the text that has come, every message ended by a line end.
  /// @throws InvalidInput in words when the other side breaks the protocol: frames that are not masked, are
  /// larger than 64 kB, or hold no text.
  std::string push(std::string_view bytes);
  /// What is to be sent back: answers to pings, and to a farewell.
  std::string take_answers();
  bool closed() const { return closed_; }

 private:
  bool take_frame(std::string& text);

  std::string rest_, message_, answers_;
  bool closed_ = false;
};

}  // namespace batten
