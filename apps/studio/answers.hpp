#pragma once
#include "studio/folder.hpp"
#include "studio/gate.hpp"
#include "studio/page.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// What is answered to an HTTP request: docs/studio-server.md. Values only; nothing here knows of sockets.
namespace batten::studio {

/// The longest file that a client may send.
inline constexpr std::size_t kMostUpload = std::size_t{256} << 20;

/// A request without its body.
struct Question {
  std::string method;  ///< "GET"
  std::string target;  ///< path and query
  std::string host, origin, cookie;
  std::string if_none_match, accept_encoding;
  std::optional<std::size_t> body_size;  ///< as announced
  bool is_upgrade = false;               ///< to a WebSocket
  bool is_ambiguous = false;             ///< Host, Origin or Cookie twice
  bool is_chunked = false;               ///< a body whose length is not told
};

/// Whether a WebSocket is meant for captures; else it is the engine's.
bool is_capture_socket(const Question& question);

/// An answer; its body is `text`, or `bytes` of the page, or an opened file.
struct Answer {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string text;
  std::string_view bytes;
  OpenedBytes file;
  std::string refused;  ///< for the log: why, where a rule of safety refused
};

/// The answers of one server. Not for several threads at once.
class Answers {
 public:
  /// All of them must outlive this object. @param folder may be null.
  Answers(Gate& gate, const Page& page, Folder* folder, std::string version);

  /// The answer where a rule refuses the request before its body is read; nothing where it may go on. For a
  /// WebSocket too.
  std::optional<Answer> refusal(const Question& question) const;
  /// @pre refusal() gave nothing.
  Answer answer(const Question& question, std::string_view body);
  /// A file that a message of the socket names by its number; nothing where there is none.
  OpenedBytes open_file(std::uint32_t number) const;

 private:
  Answer page_answer(const Question& question) const;
  Answer session_answer(const Question& question, std::string_view body);
  Answer files_answer(const Question& question, std::string_view body);
  std::string session_json() const;

  Gate& gate_;
  const Page& page_;
  Folder* folder_;
  std::string version_;
};

/// A sentence as an answer: {"ok":false,"message":…}.
Answer sentence_answer(int status, std::string_view sentence);
/// Adds what every answer carries: the rules for the page, and no permission for other sites.
void add_common_headers(Answer& answer);

}  // namespace batten::studio
