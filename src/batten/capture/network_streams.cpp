#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "batten/capture/byte_stream.hpp"
#include "batten/capture/descriptor_detail.hpp"
#include "batten/capture/web_socket.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr std::size_t kLargestRequest = 16384;

/// A socket, closed at the end of its life.
class Socket {
 public:
  explicit Socket(int descriptor = -1) : descriptor_(descriptor) {}
  ~Socket() { reset(); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void reset(int descriptor = -1) {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = descriptor;
  }
  int get() const { return descriptor_; }
  bool is_open() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

/// A socket bound to a port. @param type SOCK_STREAM or SOCK_DGRAM.
int bound_socket(int type, const std::string& address, int port) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  const std::string number = address == "localhost" ? "127.0.0.1" : address;
  if (::inet_pton(AF_INET, number.c_str(), &place.sin_addr) != 1)
    throw InvalidInput(concat("'", address,
                              "' is no address of this computer; use 127.0.0.1, or 0.0.0.0 for "
                              "all networks"));
  const int descriptor = ::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) throw InvalidInput(concat("no socket can be opened: ", std::strerror(errno)));
  const int on = 1;
  if (type == SOCK_STREAM) ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0 ||
      (type == SOCK_STREAM && ::listen(descriptor, 1) != 0)) {
    const int error = errno;
    ::close(descriptor);
    throw InvalidInput(concat("port ", port, " at ", address, " cannot be used: ", std::strerror(error),
                              "; close the other program or take another port"));
  }
  return descriptor;
}

class UdpStream : public ByteStream {
 public:
  UdpStream(const std::string& address, int port, HostClock& clock)
      : socket_(bound_socket(SOCK_DGRAM, address, port)), clock_(clock) {}

  void write(std::string_view bytes) override {
    if (sender_.sin_port == 0) return;  // nobody has written so far
    ::sendto(socket_.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&sender_),
             sizeof sender_);
  }

  std::string read(double seconds) override {
    char buffer[65536];
    std::string text;
    for (bool waited = false;;) {
      socklen_t size = sizeof sender_;
      const ssize_t n =
          ::recvfrom(socket_.get(), buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&sender_), &size);
      if (n > 0) {
        text.append(buffer, static_cast<std::size_t>(n));
        if (text.back() != '\n') text += '\n';  // a datagram ends a line
        return text;
      }
      if (n == 0) continue;
      if (waited || !detail::wait_for(socket_.get(), POLLIN, seconds, clock_)) return text;
      waited = true;
    }
  }

 private:
  Socket socket_;
  HostClock& clock_;
  sockaddr_in sender_{};
};

class WebSocketStream : public ByteStream {
 public:
  WebSocketStream(const std::string& address, int port, HostClock& clock)
      : listener_(bound_socket(SOCK_STREAM, address, port)), clock_(clock) {}

  void write(std::string_view bytes) override {
    if (client_.is_open() && shaken_) send(text_frame(bytes));
  }

  std::string read(double seconds) override {
    if (!client_.is_open()) {
      if (!detail::wait_for(listener_.get(), POLLIN, seconds, clock_)) return {};
      client_.reset(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (!client_.is_open()) return {};
      const int on = 1;
      ::setsockopt(client_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      shaken_ = false;
      request_.clear();
      frames_ = WebSocketFrames();
    }
    if (!detail::wait_for(client_.get(), POLLIN, seconds, clock_)) return {};
    char buffer[65536];
    const ssize_t n = ::recv(client_.get(), buffer, sizeof buffer, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return {};
    if (n <= 0) {
      client_.reset();
      throw SourceLost("the page or program at the other end of the WebSocket has gone");
    }
    return take({buffer, static_cast<std::size_t>(n)});
  }

 private:
  void send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(client_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n < 0 && errno == EAGAIN && detail::wait_for(client_.get(), POLLOUT, 1, clock_)) continue;
      if (n <= 0) return;  // reading will tell
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }

  std::string take(std::string_view bytes) {
    std::string first_frames;
    if (!shaken_) {
      request_ += bytes;
      const std::size_t end = request_.find("\r\n\r\n");
      if (end == std::string::npos) {
        if (request_.size() > kLargestRequest) client_.reset();
        return {};
      }
      const WebSocketHandshake handshake = answer_handshake(request_.substr(0, end + 4));
      send(handshake.answer);
      if (!handshake.accepted) {
        client_.reset();
        return {};
      }
      shaken_ = true;
      first_frames = request_.substr(end + 4);
      bytes = first_frames;
    }
    std::string text;
    try {
      text = frames_.push(bytes);
    } catch (const InvalidInput& error) {
      client_.reset();
      throw SourceLost(error.what());
    }
    send(frames_.take_answers());
    if (frames_.closed()) client_.reset();
    return text;
  }

  Socket listener_, client_;
  HostClock& clock_;
  bool shaken_ = false;
  std::string request_;
  WebSocketFrames frames_;
};

}  // namespace

std::unique_ptr<ByteStream> open_udp(const std::string& address, int port, HostClock& clock) {
  return std::make_unique<UdpStream>(address, port, clock);
}

std::unique_ptr<ByteStream> open_web_socket(const std::string& address, int port, HostClock& clock) {
  return std::make_unique<WebSocketStream>(address, port, clock);
}

}  // namespace batten
