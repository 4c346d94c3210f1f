#include "batten/capture/web_socket.hpp"

#include <array>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // of RFC 6455, 1.3
constexpr std::size_t kLargestFrame = 65536;
enum Opcode : unsigned { kContinuation = 0, kText = 1, kClose = 8, kPing = 9, kPong = 10 };

std::uint32_t rotated(std::uint32_t word, unsigned by) {
  return word << by | word >> (32U - by);
}

/// SHA-1 (FIPS 180-4, 6.1). It guards nothing here; the handshake demands it.
std::string sha1(std::string text) {
  const std::uint64_t bits = 8 * static_cast<std::uint64_t>(text.size());
  text += '\x80';
  while (text.size() % 64 != 56) text += '\0';
  for (unsigned k = 8; k-- > 0;) text += static_cast<char>(bits >> (8 * k) & 255U);
  std::array<std::uint32_t, 5> h = {0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  for (std::size_t block = 0; block < text.size(); block += 64) {
    std::array<std::uint32_t, 80> w{};
    for (std::size_t t = 0; t < 64; ++t)
      w[t / 4] = w[t / 4] << 8 | static_cast<unsigned char>(text[block + t]);
    for (std::size_t t = 16; t < 80; ++t) w[t] = rotated(w[t - 3] ^ w[t - 8] ^ w[t - 14] ^ w[t - 16], 1);
    auto [a, b, c, d, e] = h;
    for (std::size_t t = 0; t < 80; ++t) {
      std::uint32_t f = 0, k = 0;
      if (t < 20) {
        f = (b & c) | (~b & d);
        k = 0x5A827999;
      } else if (t < 40 || t >= 60) {
        f = b ^ c ^ d;
        k = t < 40 ? 0x6ED9EBA1 : 0xCA62C1D6;
      } else {
        f = (b & c) | (b & d) | (c & d);
        k = 0x8F1BBCDC;
      }
      const std::uint32_t next = rotated(a, 5) + f + e + k + w[t];
      e = d;
      d = c;
      c = rotated(b, 30);
      b = a;
      a = next;
    }
    h = {h[0] + a, h[1] + b, h[2] + c, h[3] + d, h[4] + e};
  }
  std::string digest;
  for (const std::uint32_t word : h)
    for (unsigned k = 4; k-- > 0;) digest += static_cast<char>(word >> (8 * k) & 255U);
  return digest;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

/// The value of a header of the request; names are compared without regard to case.
std::string_view header_value(std::string_view request, std::string_view name) {
  while (!request.empty()) {
    const std::size_t end = std::min(request.find('\n'), request.size());
    const std::string_view line = request.substr(0, end);
    const std::size_t colon = line.find(':');
    if (colon != std::string_view::npos && lower_case(trim(line.substr(0, colon))) == name)
      return trim(line.substr(colon + 1));
    request.remove_prefix(std::min(end + 1, request.size()));
  }
  return {};
}

/// "host" of "http://host:8765".
std::string_view host_of(std::string_view address) {
  if (const std::size_t slashes = address.find("://"); slashes != std::string_view::npos)
    address.remove_prefix(slashes + 3);
  address = address.substr(0, address.find('/'));
  if (!address.empty() && address.front() == '[') return address.substr(0, address.find(']') + 1);
  return address.substr(0, address.find(':'));
}

bool origin_allowed(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;  // not a browser
  const std::string_view from = host_of(origin);
  return from == host_of(host) || from == "localhost" || from == "127.0.0.1" || from == "[::1]";
}

WebSocketHandshake refuse(const char* status, const std::string& problem) {
  return {false,
          concat("HTTP/1.1 ", status, "\r\nContent-Type: text/plain\r\nConnection: close\r\nContent-Length: ",
                 problem.size() + 1, "\r\n\r\n", problem, "\n"),
          problem};
}

std::string frame(unsigned opcode, std::string_view payload) {
  std::string bytes(1, static_cast<char>(0x80U | opcode));
  if (payload.size() < 126) {
    bytes += static_cast<char>(payload.size());
  } else {
    bytes += static_cast<char>(126);
    bytes += static_cast<char>(payload.size() >> 8 & 255U);
    bytes += static_cast<char>(payload.size() & 255U);
  }
  return bytes.append(payload);
}

}  // namespace

WebSocketHandshake answer_handshake(std::string_view request) {
  if (request.substr(0, 4) != "GET ")
    return refuse("405 Method Not Allowed", "batten capture speaks WebSocket at this port");
  const std::string_view key = header_value(request, "sec-websocket-key");
  if (lower_case(header_value(request, "upgrade")) != "websocket" || key.size() != 24)
    return refuse("426 Upgrade Required", "batten capture speaks WebSocket at this port");
  if (!origin_allowed(header_value(request, "origin"), header_value(request, "host")))
    return refuse("403 Forbidden", "pages of other sites may not send to batten capture");
  return {true,
          concat("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: "
                 "Upgrade\r\nSec-WebSocket-Accept: ",
                 base64(sha1(std::string(key) + std::string(kGuid))), "\r\n\r\n"),
          {}};
}

std::string text_frame(std::string_view text) {
  return frame(kText, text.substr(0, 65535));
}

bool WebSocketFrames::take_frame(std::string& text) {
  const auto byte = [this](std::size_t at) { return static_cast<unsigned char>(rest_[at]); };
  if (rest_.size() < 2) return false;
  const bool last = (byte(0) & 0x80U) != 0;
  const unsigned opcode = byte(0) & 15U;
  std::size_t length = byte(1) & 127U, at = 2;
  if ((byte(0) & 0x70U) != 0 || (byte(1) & 0x80U) == 0)
    throw InvalidInput("the WebSocket client sends frames that are not masked or of an unknown kind");
  if (length == 127) throw InvalidInput("the WebSocket client sends frames larger than 64 kB");
  if (length == 126) {
    if (rest_.size() < 4) return false;
    length = byte(2) * 256U + byte(3);
    at = 4;
  }
  if (rest_.size() < at + 4 + length) return false;
  std::string payload;
  for (std::size_t i = 0; i < length; ++i) payload += static_cast<char>(byte(at + 4 + i) ^ byte(at + i % 4));
  rest_.erase(0, at + 4 + length);
  switch (opcode) {
    case kText:
    case kContinuation:
      message_ += payload;
      if (message_.size() > kLargestFrame)
        throw InvalidInput("the WebSocket client sends more than 64 kB at once");
      if (last) {
        text += message_ + "\n";
        message_.clear();
      }
      return true;
    case kClose:
      answers_ += frame(kClose, payload.substr(0, 2));
      closed_ = true;
      return false;
    case kPing:
      answers_ += frame(kPong, payload.substr(0, 125));
      return true;
    case kPong:
      return true;
    default:
      throw InvalidInput("the WebSocket client sends frames that hold no text");
  }
}

std::string WebSocketFrames::push(std::string_view bytes) {
  std::string text;
  if (closed_) return text;
  rest_ += bytes;
  while (take_frame(text)) {
  }
  return text;
}

std::string WebSocketFrames::take_answers() {
  std::string answers;
  answers.swap(answers_);
  return answers;
}

}  // namespace batten
