#include "studio/server.hpp"

#include "studio/answers.hpp"
#include "studio/connection_detail.hpp"
#include "studio/socket_detail.hpp"

#include <csignal>
#include <thread>
#include <utility>

#include <boost/asio/signal_set.hpp>
#include <fcntl.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::studio {

namespace {

/// The browser would hold the port for as long as it runs.
void keep_from_children(int descriptor) {
  fcntl(descriptor, F_SETFD, FD_CLOEXEC);
}

}  // namespace

struct Server::State {
  explicit State(ServerOptions given)
      : options(std::move(given)),
        page(options.page_folder.empty() ? Page::embedded() : Page::of_folder(options.page_folder)) {
    if (!options.place.empty()) folder.emplace(options.place);
    listen();
    port = acceptor.local_endpoint().port();
    gate.emplace(port);
    answers.emplace(*gate, page, folder ? &*folder : nullptr, options.version);
    hub.limits = options.limits;
    hub.answers = &*answers;
    hub.engine = options.engine ? options.engine : make_engine;
    desk.emplace(folder ? &*folder : nullptr, options.limits.alone);
    hub.desk = &*desk;
    hub.refused = options.refused;
  }

  /// An error where the port cannot be taken.
  error_code try_to_listen(unsigned short wanted) {
    error_code error;
    const tcp::endpoint place(net::ip::address_v4::loopback(), wanted);
    acceptor.open(place.protocol(), error);
    if (!error) acceptor.set_option(net::socket_base::reuse_address(true), error);
    if (!error) keep_from_children(acceptor.native_handle());
    if (!error) acceptor.bind(place, error);
    if (!error) acceptor.listen(net::socket_base::max_listen_connections, error);
    error_code ignored;
    if (error) acceptor.close(ignored);
    return error;
  }

  void listen() {
    if (!options.port && !try_to_listen(kUsualPort)) return;
    const unsigned short wanted = options.port.value_or(0);
    if (const error_code error = try_to_listen(wanted))
      throw InvalidInput(concat("port ", wanted, " cannot be taken: ", error.message(),
                                "; leave --port out or choose another"));
  }

  void accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
      if (hub.is_stopping) return;
      if (error) {  // mostly too many files: others may close some
        pause.expires_after(std::chrono::milliseconds(100));
        return pause.async_wait([this](error_code stopped) {
          if (!stopped) accept();
        });
      }
      keep_from_children(socket.native_handle());
      if (hub.n_connections < hub.limits.connections)
        std::make_shared<Connection>(std::move(socket), hub)->read();
      else
        hub.tell("a connection was refused: there are too many");
      accept();
    });
  }

  /// On the thread of the server.
  void begin_to_stop() {
    if (hub.is_stopping) return;
    hub.is_stopping = true;
    error_code ignored;
    acceptor.close(ignored);
    pause.cancel();
    for (const auto& [number, service] : hub.services) service->close();
    desk->stop();
    if (hub.sockets.empty()) return hub.io.stop();
    const auto sockets = hub.sockets;  // those that end take themselves out
    for (const auto& [number, socket] : sockets)
      if (const auto there = socket.lock()) there->say_farewell();
    pause.expires_after(hub.limits.farewell);
    pause.async_wait([this](error_code) { hub.io.stop(); });
  }

  ServerOptions options;
  Page page;
  std::optional<Folder> folder;
  unsigned short port = 0;
  std::optional<Gate> gate;
  std::optional<Answers> answers;
  std::optional<CaptureDesk> desk;  // outlives the services of the hub
  Hub hub;
  tcp::acceptor acceptor{hub.io};
  net::steady_timer pause{hub.io};
  net::signal_set signals{hub.io};
  std::thread thread;
};

Server::Server(ServerOptions options) : state_(std::make_unique<State>(std::move(options))) {}

Server::~Server() {
  stop();
}

unsigned short Server::port() const {
  return state_->port;
}

std::string Server::url() const {
  return concat("http://127.0.0.1:", port(), "/#", state_->gate->secret());
}

bool Server::has_page() const {
  return !state_->page.is_empty();
}

void Server::start() {
  State& state = *state_;
  if (state.options.stop_on_signals) {
    state.signals.add(SIGINT);
    state.signals.add(SIGTERM);
    state.signals.async_wait([&state](error_code error, int) {
      if (!error) state.begin_to_stop();
    });
  }
  state.accept();
  state.thread = std::thread([&state] { state.hub.io.run(); });
}

void Server::wait() {
  State& state = *state_;
  if (state.thread.joinable()) state.thread.join();
  error_code ignored;
  state.signals.clear(ignored);  // from now on they end the process, should an engine not come to its end
  state.hub.services.clear();
  state.desk->finish();
}

void Server::stop() {
  State& state = *state_;
  net::post(state.hub.io, [&state] { state.begin_to_stop(); });
  wait();
}

}  // namespace batten::studio
