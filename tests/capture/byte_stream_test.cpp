#include "batten/capture/byte_stream.hpp"

#include "scratch.hpp"

#include <cstdlib>
#include <cstring>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

void expect_refused(const std::string& path, int baud, const std::string& word) {
  SteadyClock clock;
  try {
    open_serial_port(path, baud, clock);
    ADD_FAILURE() << path;
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST(OpenSerialPort, SaysWhatIsWrongAndWhatHelps) {
  expect_refused("/dev/no-such-port", 115200, "plug the device in");
  expect_refused("/dev/null", 115200, "no serial port");
  expect_refused("/dev/null", 12345, "baud");
}

/// A pseudo-terminal whose other side the test holds.
struct Terminal {
  int master = posix_openpt(O_RDWR | O_NOCTTY);
  std::string path;
  Terminal() {
    if (grantpt(master) == 0 && unlockpt(master) == 0) path = ptsname(master);
  }
  ~Terminal() { unplug(); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  void unplug() {
    if (master >= 0) close(master);
    master = -1;
  }
};

TEST(SerialPort, PassesEveryByteBothWaysAndIsForOneAlone) {
  Terminal terminal;
  SteadyClock clock;
  const auto port = open_serial_port(terminal.path, 230400, clock);
  expect_refused(terminal.path, 115200, "busy");
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  ASSERT_EQ(write(terminal.master, all.data(), all.size()), 256);
  std::string got;
  while (got.size() < 256) got += port->read(10);
  EXPECT_EQ(got, all);
  port->write(all);
  got.clear();
  char buffer[256];
  while (got.size() < 256) {
    const ssize_t n = read(terminal.master, buffer, sizeof buffer);
    ASSERT_GT(n, 0);
    got.append(buffer, static_cast<std::size_t>(n));
  }
  EXPECT_EQ(got, all);
  EXPECT_TRUE(port->read(0).empty());
}

TEST(SerialPort, IsLostWhenItIsUnplugged) {
  Terminal terminal;
  SteadyClock clock;
  const auto port = open_serial_port(terminal.path, 115200, clock);
  terminal.unplug();
  EXPECT_THROW(port->read(1), SourceLost);
}

/// A port of this computer that nobody uses, as far as can be known.
int free_port(int type) {
  const int probe = socket(AF_INET, type, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof place;
  bind(probe, reinterpret_cast<sockaddr*>(&place), size);
  getsockname(probe, reinterpret_cast<sockaddr*>(&place), &size);
  close(probe);
  return ntohs(place.sin_port);
}

int connected(int type, int port) {
  const int client = socket(AF_INET, type, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  EXPECT_EQ(connect(client, reinterpret_cast<sockaddr*>(&place), sizeof place), 0);
  return client;
}

TEST(OpenUdp, EndsLinesWithDatagramsAndAnswersTheSender) {
  SteadyClock clock;
  const int port = free_port(SOCK_DGRAM);
  const auto stream = open_udp("127.0.0.1", port, clock);
  EXPECT_THROW(open_udp("127.0.0.1", port, clock), InvalidInput);
  EXPECT_THROW(open_udp("no address", port, clock), InvalidInput);
  const int client = connected(SOCK_DGRAM, port);
  ASSERT_EQ(send(client, "K,1,2,end", 9, 0), 9);
  EXPECT_EQ(stream->read(10), "K,1,2,end\n");
  stream->write("?\n");
  char buffer[8];
  ASSERT_EQ(recv(client, buffer, sizeof buffer, 0), 2);
  close(client);
}

TEST(OpenWebSocket, ShakesHandsAndReadsTextOfOneClientAfterTheOther) {
  SteadyClock clock;
  const int port = free_port(SOCK_STREAM);
  const auto stream = open_web_socket("127.0.0.1", port, clock);
  for (int round = 0; round < 2; ++round) {
    const int client = connected(SOCK_STREAM, port);
    const std::string request =
        "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    // The first frame comes with the request: nothing of it may be lost.
    const std::string all = request + "\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58";
    ASSERT_EQ(send(client, all.data(), all.size(), 0), static_cast<ssize_t>(all.size()));
    std::string text;
    while (text.empty()) text += stream->read(10);
    EXPECT_EQ(text, "Hello\n");
    char buffer[512];
    const ssize_t n = recv(client, buffer, sizeof buffer, 0);
    ASSERT_GT(n, 12);
    EXPECT_EQ(std::string(buffer, 12), "HTTP/1.1 101");
    close(client);
    EXPECT_THROW(for (;;) stream->read(10);, SourceLost);
  }
}

}  // namespace
}  // namespace batten::test
