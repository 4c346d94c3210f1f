#pragma once
#include "studio/server.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace batten::test {

/// An answer of HTTP as it came.
struct HttpAnswer {
  int status = 0;  ///< 0: the connection was closed without an answer
  std::string head;
  std::string body;
  /// The value of a header; empty where it is missing.
  std::string header(const std::string& name) const;
};

/// A connection to 127.0.0.1 that sends what it is told, right or wrong: nothing here is shared with the
/// server.
class Wire {
 public:
  explicit Wire(unsigned short port);
  ~Wire();
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  /// False where the other side has closed.
  bool send(const std::string& bytes) const;
  /// All until `end` stands in it, or n bytes more; less where the other side closes or 3 s pass.
  std::string until(const std::string& end);
  std::string exactly(std::size_t n);
  /// Whether the other side closes within a time; what comes before is thrown away.
  bool closes_within(std::chrono::milliseconds time);
  HttpAnswer answer(bool has_body = true);

 private:
  bool receive();
  int socket_ = -1;
  std::string received_;
};

/// A frame that the server has sent.
struct Received {
  int opcode = 0;  ///< 1 text, 2 binary, 8 close; 0: the connection was closed
  std::string payload;
};

/// A server that runs, and the words of a browser that may speak to it.
class Studio {
 public:
  explicit Studio(studio::ServerOptions options = {});

  studio::Server& server() { return *server_; }
  /// What the server has told of refusals so far.
  std::string told() const;
  std::string host() const;
  std::string origin() const { return "http://" + host(); }
  std::string secret() const;
  /// The cookie, traded for the secret on the first call.
  const std::string& cookie();

  /// A request on a connection of its own. @param headers lines, each with its end.
  HttpAnswer ask(const std::string& method, const std::string& target, const std::string& headers = {},
                 const std::string& body = {}) const;
  /// The same with cookie and Origin.
  HttpAnswer ask_as_page(const std::string& method, const std::string& target, const std::string& body = {});
  /// A WebSocket that is asked for; its answer has not been read.
  std::unique_ptr<Wire> begin_socket(const std::string& path = "/engine");
  /// A WebSocket that is open; null with `status` where it was refused.
  std::unique_ptr<Wire> open_socket(int* status = nullptr, const std::string& path = "/engine");

 private:
  struct Told {
    std::mutex mutex;
    std::string text;
  };
  std::shared_ptr<Told> told_ = std::make_shared<Told>();
  std::unique_ptr<studio::Server> server_;
  std::string cookie_;
};

/// A frame of a client, masked as it must be. @param announced a length other than that of the payload.
std::string masked(int opcode, const std::string& payload, std::optional<std::uint64_t> announced = {});
Received receive_frame(Wire& wire);
/// A reply: its text and its arrays, events before it left out.
struct SocketReply {
  std::string text;
  std::vector<std::string> events;
  std::vector<std::string> arrays;
};
SocketReply receive_reply(Wire& wire);

}  // namespace batten::test
