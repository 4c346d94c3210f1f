#pragma once
#include "studio/answers.hpp"
#include "studio/socket_detail.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

// Part of server.cpp: a connection of HTTP, which may become a socket.
namespace batten::studio {

inline constexpr std::uint32_t kMostHead = 8192;
inline constexpr std::size_t kMostDiscarded = std::size_t{1} << 20;

using HttpParser = http::request_parser<http::string_body>;

inline std::string text_of(const http::request<http::string_body>& request, http::field field) {
  const auto value = request[field];
  return {value.data(), value.size()};
}

inline Question question_of(const HttpParser& parser) {
  const auto& request = parser.get();
  Question question;
  question.method = std::string(request.method_string());
  question.target = std::string(request.target());
  question.host = text_of(request, http::field::host);
  question.origin = text_of(request, http::field::origin);
  question.cookie = text_of(request, http::field::cookie);
  question.if_none_match = text_of(request, http::field::if_none_match);
  question.accept_encoding = text_of(request, http::field::accept_encoding);
  if (const auto length = parser.content_length()) question.body_size = static_cast<std::size_t>(*length);
  question.is_chunked = parser.chunked();
  question.is_upgrade = websocket::is_upgrade(request);
  for (const http::field field : {http::field::host, http::field::origin, http::field::cookie})
    question.is_ambiguous = question.is_ambiguous || request.count(field) > 1;
  return question;
}

/// The answer to a head or a body that is no HTTP, or too long.
inline Answer parse_failure(error_code error) {
  if (error == http::error::header_limit) return sentence_answer(431, "the head is too long");
  if (error == http::error::body_limit) return sentence_answer(413, "the body is too long");
  return sentence_answer(400, concat("this is no HTTP: ", error.message()));
}

/// A connection of HTTP, one request after the other.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Hub& hub) : hub_(hub), stream_(std::move(socket)) { ++hub_.n_connections; }
  ~Connection() { --hub_.n_connections; }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void read() {
    question_ = {};
    parser_.emplace();
    parser_->header_limit(kMostHead);
    parser_->body_limit(kMostUpload);
    stream_.expires_after(hub_.limits.head);
    http::async_read_header(stream_, buffer_, *parser_,
                            [me = shared_from_this()](error_code error, std::size_t) {
                              if (!me->has_failed(error)) me->judge();
                            });
  }

 private:
  /// Whether reading failed; the answer to that is on its way then, where there is one.
  bool has_failed(error_code error) {
    if (!error) return false;
    const bool is_idle = buffer_.size() == 0 && !parser_->got_some();
    if (error == beast::error::timeout && !is_idle) hub_.tell("a request was dropped: it came too slowly");
    const bool is_http = error.category() == http::make_error_code(http::error::bad_method).category();
    if (is_http && error != http::error::end_of_stream && error != http::error::partial_message) {
      hub_.tell(concat("a request was refused: ", error.message()));
      send(parse_failure(error), false);
    }
    return true;
  }

  void judge() {
    question_ = question_of(*parser_);
    const bool keep = parser_->get().keep_alive();
    if (auto refusal = hub_.answers->refusal(question_))
      return send(std::move(*refusal), keep && question_.body_size.value_or(0) == 0 && !question_.is_chunked);
    if (question_.is_upgrade) return upgrade();
    stream_.expires_after(hub_.limits.body);
    http::async_read(stream_, buffer_, *parser_,
                     [me = shared_from_this(), keep](error_code error, std::size_t) {
                       if (me->has_failed(error)) return;
                       me->send(me->hub_.answers->answer(me->question_, me->parser_->get().body()), keep);
                     });
  }

  void upgrade() {
    if (hub_.services.size() >= hub_.limits.sockets) {
      Answer answer = sentence_answer(503, "there are as many windows as the server keeps; close one");
      answer.refused = "too many sockets";
      return send(std::move(answer), false);
    }
    std::make_shared<Socket>(stream_.release_socket(), hub_)
        ->accept(parser_->get(), is_capture_socket(question_));
  }

  void send(Answer answer, bool keep) {
    if (!answer.refused.empty())
      hub_.tell(concat(answer.status, " ", question_.method, " ", question_.target, ": ", answer.refused));
    add_common_headers(answer);
    const auto held = std::make_shared<Answer>(std::move(answer));
    const bool is_file = held->file.descriptor.is_open();
    const std::string_view bytes = held->text.empty() ? held->bytes : std::string_view(held->text);
    const auto size = is_file ? held->file.size : bytes.size();
    if (question_.method == "HEAD" || held->status == 304) {
      http::response<http::empty_body> response = begin<http::empty_body>(*held, keep);
      if (held->status != 304) response.content_length(size);
      return send(std::move(response), size, held);
    }
    if (is_file) {
      auto response = begin<http::file_body>(*held, keep);
      beast::file_posix file;
      file.native_handle(held->file.descriptor.release());
      error_code error;
      response.body().reset(std::move(file), error);
      if (error) return;
      response.prepare_payload();
      return send(std::move(response), size, held);
    }
    auto response = begin<http::span_body<const char>>(*held, keep);
    response.body() = beast::span<const char>(bytes.data(), bytes.size());
    response.prepare_payload();
    send(std::move(response), size, held);
  }

  template <typename Body>
  static http::response<Body> begin(const Answer& answer, bool keep) {
    http::response<Body> response;
    response.version(11);
    response.result(static_cast<unsigned>(answer.status));
    for (const auto& [name, value] : answer.headers) response.insert(name, value);
    response.keep_alive(keep);
    return response;
  }

  template <typename Body>
  void send(http::response<Body> response, std::size_t size, std::shared_ptr<Answer> answer) {
    auto held = std::make_shared<http::response<Body>>(std::move(response));
    stream_.expires_after(time_for(size, hub_.limits));
    http::async_write(
        stream_, *held,
        [me = shared_from_this(), held, answer = std::move(answer)](error_code error, std::size_t) {
          if (error == beast::error::timeout) me->hub_.tell("an answer was dropped: it is taken too slowly");
          if (error) return;
          if (held->keep_alive()) return me->read();
          me->linger();
        });
  }

  /// Closes for a client that may still be sending: cut off at once, it would not see the answer.
  void linger() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(hub_.limits.farewell);
    discard();
  }

  void discard() {
    stream_.async_read_some(net::buffer(discarded_),
                            [me = shared_from_this()](error_code error, std::size_t n) {
                              me->n_discarded_ += n;
                              if (!error && me->n_discarded_ < kMostDiscarded) me->discard();
                            });
  }

  Hub& hub_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<HttpParser> parser_;
  Question question_;
  std::array<char, 4096> discarded_{};
  std::size_t n_discarded_ = 0;
};

}  // namespace batten::studio
