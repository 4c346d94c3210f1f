#pragma once
#include "studio/engine_thread.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace batten::studio {

/// What a client may take of the server. The defaults are for use; tests take shorter times.
struct ServerLimits {
  std::chrono::milliseconds head{10000};    ///< until the head of a request is there, also of the next one
  std::chrono::milliseconds body{60000};    ///< until its body is
  std::chrono::milliseconds write{30000};   ///< until a client has taken a frame, or an answer and 1 s a MiB
  std::chrono::milliseconds idle{120000};   ///< a socket that answers no ping
  std::chrono::milliseconds farewell{500};  ///< for sockets to close at the end
  std::chrono::milliseconds alone{60000};   ///< a capture that no window looks at goes on
  std::size_t sockets = 8;
  std::size_t connections = 64;  ///< besides the sockets
};

struct ServerOptions {
  /// 0 takes a free one. Unset: kUsualPort where it is free, so that the page finds again what the browser
  /// keeps for its address; else a free one.
  std::optional<unsigned short> port;
  std::string page_folder;       ///< files of the page; empty takes those that the program holds
  std::string place;             ///< the folder or the file to work on; empty for none
  std::string version;           ///< told to the page
  bool stop_on_signals = false;  ///< SIGINT and SIGTERM end wait()
  ServerLimits limits;
  MakeHandle engine;                                ///< empty takes batten::Engine
  std::function<void(const std::string&)> refused;  ///< told why, on a thread of the server; may be empty
};

/// The server of the studio, on 127.0.0.1 alone: HTTP for the page and files, WebSockets for the native
/// engine and for captures. docs/studio-server.md has the messages and the rules of safety.
class Server {
 public:
  static constexpr unsigned short kUsualPort = 8617;

  /// Listens from now on; answers from start() on.
  /// @throws InvalidInput where the port is taken, FileError where there is no such folder.
  explicit Server(ServerOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  unsigned short port() const;
  /// The address to open, with the secret behind its #.
  std::string url() const;
  /// Whether there is a page to show.
  bool has_page() const;

  void start();
  /// Until stop() or a signal.
  void wait();
  /// Closes sockets and connections, stops what the engines compute, and waits for it.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace batten::studio
