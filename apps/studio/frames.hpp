#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "batten/engine/reply.hpp"

// The messages of the socket /engine as values: docs/studio-server.md#messages. Nothing here knows of
// sockets.
namespace batten::studio {

/// The longest frame of a client, and the longest text among them: the bytes of files come as binary frames.
inline constexpr std::size_t kMostFrame = std::size_t{64} << 20;
inline constexpr std::size_t kMostText = std::size_t{8} << 20;

/// A message for the engine, complete with its bytes.
struct Request {
  std::uint32_t id = 0;
  std::string text;                   ///< the JSON as it came
  std::string bytes;                  ///< of the frame that followed, where it announced one
  std::optional<std::uint32_t> file;  ///< the number of a file of the folder that stands for bytes
};
/// The request `target` is to stop, whether it runs or waits.
struct Cancel {
  std::uint32_t target = 0;
};
/// A frame, or a request with its frames, that nobody can carry out.
struct Problem {
  std::optional<std::uint32_t> id;  ///< of the request, where there is one
  std::string sentence;
};
using Incoming = std::variant<Request, Cancel, Problem>;

/// Puts the frames of one client together to messages. A message with "bytes": n is complete with the next
/// binary frame, which must hold n bytes.
class FrameReader {
 public:
  /// What is complete now: mostly one message, none after an announcement, two where a text comes in place of
  /// announced bytes.
  std::vector<Incoming> text(std::string frame);
  std::vector<Incoming> binary(std::string frame);

 private:
  std::optional<Request> announced_;
  std::uint64_t n_announced_ = 0;
};

/// A frame to a client: text, or binary with a head of its own before the body.
struct Frame {
  bool is_text = true;
  bool may_be_dropped = false;  ///< progress, where the client does not keep up
  std::string head;             ///< all of a text
  std::vector<std::byte> body;
  std::size_t size() const { return head.size() + body.size(); }
};

/// What stands before the elements of an array: four numbers of 32 bits, little-endian.
struct ArrayHead {
  static constexpr std::size_t kSize = 16;
  static constexpr std::uint32_t kArray = 1;  ///< the one kind of binary frame so far

  std::uint32_t kind = kArray;
  std::uint32_t id = 0;     ///< of the request
  std::uint32_t count = 0;  ///< elements: entries times columns
  std::uint32_t type = 0;   ///< 1 float32, 2 uint32, 3 uint8
};
std::string encode(const ArrayHead& head);
/// The head of a binary frame; nothing where the frame is not as long as it says, or of an unknown kind or
/// type.
std::optional<ArrayHead> decode_array(std::string_view frame);

/// A reply of the engine as frames: {"id":…,"arrays":[…],"ok":…}, then one frame per array.
std::vector<Frame> frames_of(std::uint32_t id, Reply reply);
/// A refusal in the engine's form.
Frame failure_frame(std::optional<std::uint32_t> id, std::string_view kind, std::string_view sentence);
Frame progress_frame(std::uint32_t id, std::string_view stage, double fraction);

}  // namespace batten::studio
