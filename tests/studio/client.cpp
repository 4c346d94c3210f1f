#include "studio/client.hpp"

#include <algorithm>
#include <cstdlib>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "batten/core/text.hpp"

namespace batten::test {

namespace {

constexpr int kPatience = 3000;  // ms for the next bytes

}  // namespace

std::string HttpAnswer::header(const std::string& name) const {
  const std::string lower = lower_case(head);
  const std::size_t at = lower.find("\r\n" + lower_case(name) + ":");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 3;
  return std::string(trim(head.substr(begin, head.find("\r\n", begin) - begin)));
}

Wire::Wire(unsigned short port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
}

Wire::~Wire() {
  ::close(socket_);
}

bool Wire::send(const std::string& bytes) const {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

bool Wire::receive() {
  pollfd ready{socket_, POLLIN, 0};
  if (::poll(&ready, 1, kPatience) <= 0) return false;
  char buffer[65536];
  const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
  if (n <= 0) return false;
  received_.append(buffer, static_cast<std::size_t>(n));
  return true;
}

std::string Wire::until(const std::string& end) {
  std::size_t at = received_.find(end);
  while (at == std::string::npos && receive()) at = received_.find(end);
  return exactly(at == std::string::npos ? received_.size() : at + end.size());
}

std::string Wire::exactly(std::size_t n) {
  while (received_.size() < n && receive()) continue;
  n = std::min(n, received_.size());
  std::string bytes = received_.substr(0, n);
  received_.erase(0, n);
  return bytes;
}

bool Wire::closes_within(std::chrono::milliseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    pollfd ready{socket_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&ready, 1, static_cast<int>(left.count())) <= 0) return false;
    char buffer[65536];
    if (::recv(socket_, buffer, sizeof buffer, 0) <= 0) return true;
  }
}

HttpAnswer Wire::answer(bool has_body) {
  HttpAnswer answer;
  answer.head = until("\r\n\r\n");
  if (answer.head.size() < 12) return answer;
  answer.status = std::atoi(answer.head.c_str() + 9);
  const std::string length = answer.header("Content-Length");
  if (has_body && !length.empty()) answer.body = exactly(std::stoul(length));
  return answer;
}

Studio::Studio(studio::ServerOptions options) {
  if (!options.port) options.port = 0;
  options.refused = [told = told_](const std::string& sentence) {
    const std::lock_guard lock(told->mutex);
    told->text += sentence + "\n";
  };
  server_ = std::make_unique<studio::Server>(std::move(options));
  server_->start();
}

std::string Studio::told() const {
  const std::lock_guard lock(told_->mutex);
  return told_->text;
}

std::string Studio::host() const {
  return concat("127.0.0.1:", server_->port());
}

std::string Studio::secret() const {
  const std::string url = server_->url();
  return url.substr(url.find('#') + 1);
}

const std::string& Studio::cookie() {
  if (!cookie_.empty()) return cookie_;
  const HttpAnswer answer =
      ask("POST", "/session", "Origin: " + origin() + "\r\n", "{\"secret\":\"" + secret() + "\"}");
  EXPECT_EQ(answer.status, 200) << answer.body;
  const std::string set = answer.header("Set-Cookie");
  return cookie_ = set.substr(0, set.find(';'));
}

HttpAnswer Studio::ask(const std::string& method, const std::string& target, const std::string& headers,
                       const std::string& body) const {
  Wire wire(server_->port());
  std::string request = concat(method, " ", target, " HTTP/1.1\r\n");
  if (headers.find("Host:") == std::string::npos) request += "Host: " + host() + "\r\n";
  request += headers;
  if (method == "POST" && headers.find("Content-Length") == std::string::npos)
    request += concat("Content-Length: ", body.size(), "\r\n");
  EXPECT_TRUE(wire.send(request + "\r\n" + body));
  return wire.answer(method != "HEAD");
}

HttpAnswer Studio::ask_as_page(const std::string& method, const std::string& target,
                               const std::string& body) {
  return ask(method, target, "Cookie: " + cookie() + "\r\nOrigin: " + origin() + "\r\n", body);
}

std::unique_ptr<Wire> Studio::begin_socket(const std::string& path) {
  auto wire = std::make_unique<Wire>(server_->port());
  wire->send("GET " + path + " HTTP/1.1\r\nHost: " + host() + "\r\nOrigin: " + origin() +
             "\r\nCookie: " + cookie() +
             "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  return wire;
}

std::unique_ptr<Wire> Studio::open_socket(int* status, const std::string& path) {
  auto wire = begin_socket(path);
  const HttpAnswer answer = wire->answer();
  if (status != nullptr) *status = answer.status;
  if (answer.status != 101) return nullptr;
  // The answer to the key that RFC 6455, 1.3, works out.
  EXPECT_EQ(answer.header("Sec-WebSocket-Accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  return wire;
}

std::string masked(int opcode, const std::string& payload, std::optional<std::uint64_t> announced) {
  const std::uint64_t length = announced.value_or(payload.size());
  std::string frame(1, static_cast<char>(0x80 | opcode));
  const int n_bytes = length < 126 ? 0 : length < 65536 ? 2 : 8;
  frame += static_cast<char>(0x80 | (n_bytes == 0 ? static_cast<int>(length) : n_bytes == 2 ? 126 : 127));
  for (int k = n_bytes - 1; k >= 0; --k) frame += static_cast<char>(length >> (8 * k) & 0xff);
  const std::string mask = "\x12\x34\x56\x78";
  frame += mask;
  for (std::size_t k = 0; k < payload.size(); ++k) frame += static_cast<char>(payload[k] ^ mask[k % 4]);
  return frame;
}

Received receive_frame(Wire& wire) {
  Received received;
  for (bool is_last = false; !is_last;) {
    const std::string head = wire.exactly(2);
    if (head.size() < 2) return {};
    is_last = (head[0] & 0x80) != 0;
    if ((head[0] & 15) != 0) received.opcode = head[0] & 15;
    std::uint64_t length = static_cast<unsigned char>(head[1]) & 127U;
    if (length >= 126) {
      const std::string digits = wire.exactly(length == 126 ? 2 : 8);
      length = 0;
      for (const char c : digits) length = length << 8 | static_cast<unsigned char>(c);
    }
    received.payload += wire.exactly(length);
  }
  return received;
}

SocketReply receive_reply(Wire& wire) {
  SocketReply reply;
  for (;;) {
    const Received frame = receive_frame(wire);
    EXPECT_EQ(frame.opcode, 1);
    if (frame.opcode != 1) return reply;
    const auto json = nlohmann::json::parse(frame.payload, nullptr, false);
    EXPECT_TRUE(json.is_object()) << frame.payload;
    if (json.contains("event")) {
      reply.events.push_back(frame.payload);
      continue;
    }
    reply.text = frame.payload;
    for (std::size_t k = 0; k < json.at("arrays").size(); ++k) {
      const Received array = receive_frame(wire);
      EXPECT_EQ(array.opcode, 2);
      reply.arrays.push_back(array.payload);
    }
    return reply;
  }
}

}  // namespace batten::test
