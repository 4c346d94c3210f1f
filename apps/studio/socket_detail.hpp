#pragma once
#include "studio/answers.hpp"
#include "studio/capture_desk.hpp"
#include "studio/engine_thread.hpp"
#include "studio/server.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "batten/core/text.hpp"

// Part of server.cpp, the one source that includes Beast: the socket of a window. All of it runs on the
// thread of the server; engines have threads of their own and post to it.
namespace batten::studio {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = net::ip::tcp;
using boost::system::error_code;

inline constexpr std::size_t kMostQueued = 1024;         // frames for a client that does not read
inline constexpr std::size_t kQueuedBeforeDropping = 4;  // more than these: progress is dropped

class Socket;

/// What all connections share.
struct Hub {
  ServerLimits limits;
  Answers* answers = nullptr;
  MakeHandle engine;
  CaptureDesk* desk = nullptr;
  std::function<void(const std::string&)> refused;
  bool is_stopping = false;
  std::size_t n_connections = 0;
  int n_sockets_ever = 0;
  std::map<int, std::unique_ptr<Service>> services;  // until they are at rest: later than their sockets
  std::map<int, std::weak_ptr<Socket>> sockets;
  net::io_context io{1};  // last: what waits in it uses all of the above

  /// Text of a client, made safe for a terminal.
  void tell(std::string sentence) const {
    if (!refused) return;
    if (sentence.size() > 300) sentence.resize(300);
    for (char& c : sentence)
      if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
    refused(sentence);
  }
};

/// Time to take so many bytes: slow links are none of ours.
inline std::chrono::milliseconds time_for(std::size_t n_bytes, const ServerLimits& limits) {
  return limits.write + std::chrono::seconds(n_bytes >> 20);
}

/// A window: frames in, frames out.
class Socket : public std::enable_shared_from_this<Socket> {
 public:
  Socket(tcp::socket&& socket, Hub& hub)
      : hub_(hub), number_(hub.n_sockets_ever++), stream_(std::move(socket)), deadline_(hub.io) {}

  void accept(const http::request<http::string_body>& request, bool is_capture) {
    hub_.sockets[number_] = weak_from_this();
    const std::weak_ptr<Socket> self = weak_from_this();
    Service::Hooks hooks;
    hooks.send = [self, &hub = hub_](std::vector<Frame> frames) {
      net::post(hub.io, [self, frames = std::move(frames)]() mutable {
        if (const auto socket = self.lock()) socket->queue(std::move(frames));
      });
    };
    hooks.ended = [&hub = hub_, number = number_] {
      net::post(hub.io, [&hub, number] { hub.services.erase(number); });
    };
    if (is_capture)
      hub_.services[number_] = hub_.desk->window(std::move(hooks));
    else
      hub_.services[number_] = std::make_unique<EngineThread>(hub_.engine, std::move(hooks));
    beast::get_lowest_layer(stream_).expires_never();  // the WebSocket has times of its own
    stream_.set_option(websocket::stream_base::timeout{hub_.limits.head, hub_.limits.idle, true});
    stream_.read_message_max(kMostFrame);
    stream_.async_accept(request, [me = shared_from_this()](error_code error) {
      if (error || me->has_ended_) return me->end();
      me->is_open_ = true;
      if (me->hub_.is_stopping) return me->say_farewell();
      me->read();
      me->write();  // what has come meanwhile
    });
  }

  void queue(std::vector<Frame> frames) {
    for (Frame& frame : frames) {
      if (frame.may_be_dropped && queue_.size() > kQueuedBeforeDropping)
        tell_sent(frame.size());
      else
        queue_.push_back(std::move(frame));
    }
    if (queue_.size() > kMostQueued) return drop("it does not take its replies");
    write();
  }

  void say_farewell() {
    // The answer to the client's first words may still be on its way; a stream takes one write at a time.
    // Said after it.
    if (!is_open_) return;
    stream_.async_close(websocket::close_code::going_away,
                        [me = shared_from_this()](error_code) { me->end(); });
  }

 private:
  /// Null where it has come to its end before the socket, when the server stops.
  Service* service() const {
    const auto found = hub_.services.find(number_);
    return found == hub_.services.end() ? nullptr : found->second.get();
  }
  void tell_sent(std::size_t n_bytes) const {
    if (Service* there = service()) there->sent(n_bytes);
  }

  void read() {
    stream_.async_read(buffer_, [me = shared_from_this()](error_code error, std::size_t) {
      if (me->has_ended_) return;
      if (error == websocket::error::message_too_big)
        me->hub_.tell(concat("socket ", me->number_, ": a frame above ", kMostFrame, " bytes"));
      if (error) return me->end();
      me->take();
    });
  }

  void take() {
    std::string frame = beast::buffers_to_string(buffer_.data());
    buffer_ = beast::flat_buffer();  // the memory of a large file goes back
    std::vector<Incoming> complete =
        stream_.got_text() ? reader_.text(std::move(frame)) : reader_.binary(std::move(frame));
    std::vector<Frame> replies;
    for (Incoming& incoming : complete) {
      if (const auto* cancel = std::get_if<Cancel>(&incoming)) {
        if (Service* there = service()) there->cancel(cancel->target);
      } else if (const auto* problem = std::get_if<Problem>(&incoming)) {
        hub_.tell(concat("socket ", number_, ": ", problem->sentence));
        replies.push_back(failure_frame(problem->id, "protocol", problem->sentence));
      } else {
        ask(std::get<Request>(std::move(incoming)), replies);
      }
    }
    queue(std::move(replies));
    if (!has_ended_) read();
  }

  void ask(Request request, std::vector<Frame>& replies) {
    const std::uint32_t id = request.id;
    OpenedBytes file;
    if (request.file) {
      file = hub_.answers->open_file(*request.file);
      if (!file.descriptor.is_open())
        return replies.push_back(failure_frame(id, "error", "there is no file of this number"));
    }
    Service* there = service();
    if (there != nullptr && !there->ask(std::move(request), std::move(file)))
      replies.push_back(
          failure_frame(id, "busy", "too many requests wait; ask again when some are answered"));
  }

  void write() {
    // Before it is open the answer to the client's first words is being written.
    if (!is_open_ || is_writing_ || queue_.empty() || has_ended_) return;
    is_writing_ = true;
    const Frame& frame = queue_.front();
    stream_.text(frame.is_text);
    deadline_.expires_after(time_for(frame.size(), hub_.limits));
    deadline_.async_wait([me = shared_from_this()](error_code error) {
      if (!error && me->deadline_.expiry() <= net::steady_timer::clock_type::now())
        me->drop("it takes its replies too slowly");
    });
    const std::array<net::const_buffer, 2> parts = {net::buffer(frame.head), net::buffer(frame.body)};
    stream_.async_write(parts, [me = shared_from_this()](error_code error, std::size_t) {
      me->is_writing_ = false;
      if (me->has_ended_) return;
      if (error) return me->end();
      me->deadline_.expires_at(net::steady_timer::time_point::max());
      me->tell_sent(me->queue_.front().size());
      me->queue_.pop_front();
      me->write();
    });
  }

  void drop(const char* why) {
    if (has_ended_) return;
    hub_.tell(concat("socket ", number_, " was dropped: ", why));
    end();
  }

  void end() {
    if (has_ended_) return;
    has_ended_ = true;
    deadline_.cancel();
    if (Service* there = service()) there->close();
    beast::get_lowest_layer(stream_).close();
    hub_.sockets.erase(number_);
    if (hub_.is_stopping && hub_.sockets.empty()) hub_.io.stop();
  }

  Hub& hub_;
  int number_;
  websocket::stream<beast::tcp_stream> stream_;
  net::steady_timer deadline_;  // for the frame that is being written
  beast::flat_buffer buffer_;
  FrameReader reader_;
  std::deque<Frame> queue_;
  bool is_open_ = false;  // the client has its answer, frames may follow
  bool is_writing_ = false;
  bool has_ended_ = false;
};

}  // namespace batten::studio
