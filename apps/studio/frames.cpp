#include "studio/frames.hpp"

#include <array>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "batten/core/text.hpp"

namespace batten::studio {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kLargestId = std::numeric_limits<std::uint32_t>::max();

struct ElementForm {
  std::uint32_t code;
  const char* name;
  std::size_t size;
};

ElementForm form_of(ElementType type) {
  switch (type) {
    case ElementType::Float32:
      return {1, "float32", 4};
    case ElementType::Uint32:
      return {2, "uint32", 4};
    default:
      return {3, "uint8", 1};
  }
}

/// The bytes of an element; 0 for a code that there is not.
std::size_t element_size(std::uint32_t code) {
  if (code == 3) return 1;
  return code == 1 || code == 2 ? 4 : 0;
}

std::optional<std::uint64_t> whole_number(const Json& message, const char* name, std::uint64_t most) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_number_unsigned()) return std::nullopt;
  const auto value = found->get<std::uint64_t>();
  return value <= most ? std::optional(value) : std::nullopt;
}

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// A text frame by itself. Where it announces bytes, `n_bytes` is set and the request is not complete.
Incoming message_of(std::string frame, std::optional<std::uint64_t>& n_bytes) {
  if (frame.size() > kMostText)
    return Problem{{}, concat("a text of ", frame.size(), " bytes is too long; send files as bytes")};
  const Json message = Json::parse(frame, nullptr, false);
  if (!message.is_object()) return Problem{{}, "the message is no JSON object"};
  const auto op = message.find("op");
  if (op == message.end() || !op->is_string()) return Problem{{}, "the message has no 'op'"};
  if (*op == "cancel") {
    const auto target = whole_number(message, "target", kLargestId);
    if (!target) return Problem{{}, "'target' of cancel must be the id of a request"};
    return Cancel{static_cast<std::uint32_t>(*target)};
  }
  const auto id = whole_number(message, "id", kLargestId);
  if (!id) return Problem{{}, "'id' of the message must be a whole number from 0 to 4294967295"};
  const auto short_id = static_cast<std::uint32_t>(*id);
  if (message.contains("bytes")) {
    n_bytes = whole_number(message, "bytes", kMostFrame);
    if (!n_bytes)
      return Problem{short_id, concat("'bytes' must be a whole number from 0 to ", kMostFrame,
                                      ", the length of the binary frame that follows")};
  }
  std::optional<std::uint32_t> file;
  if (message.contains("file")) {
    const auto number = whole_number(message, "file", kLargestId);
    if (!number || n_bytes)
      return Problem{short_id, "'file' must be the number of a file, without 'bytes' beside it"};
    file = static_cast<std::uint32_t>(*number);
  }
  return Request{short_id, std::move(frame), {}, file};
}

void append(std::string& text, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(value >> shift & 0xffU);
}

std::uint32_t number_at(std::string_view frame, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(frame[at + k])) << (8 * k);
  return value;
}

}  // namespace

std::vector<Incoming> FrameReader::text(std::string frame) {
  std::vector<Incoming> complete;
  if (announced_) {
    complete.emplace_back(Problem{announced_->id, "the bytes that were announced did not follow"});
    announced_.reset();
  }
  std::optional<std::uint64_t> n_bytes;
  Incoming message = message_of(std::move(frame), n_bytes);
  if (n_bytes && std::holds_alternative<Request>(message)) {
    announced_ = std::get<Request>(std::move(message));
    n_announced_ = *n_bytes;
  } else {
    complete.push_back(std::move(message));
  }
  return complete;
}

std::vector<Incoming> FrameReader::binary(std::string frame) {
  if (!announced_) return {Problem{{}, "a binary frame came that no message had announced"}};
  Request request = std::move(*announced_);
  announced_.reset();
  if (frame.size() != n_announced_)
    return {Problem{request.id,
                    concat(n_announced_, " bytes were announced, ", frame.size(), " bytes followed")}};
  request.bytes = std::move(frame);
  return {std::move(request)};
}

std::string encode(const ArrayHead& head) {
  std::string bytes;
  for (const std::uint32_t value : {head.kind, head.id, head.count, head.type}) append(bytes, value);
  return bytes;
}

std::optional<ArrayHead> decode_array(std::string_view frame) {
  if (frame.size() < ArrayHead::kSize) return std::nullopt;
  const ArrayHead head{number_at(frame, 0), number_at(frame, 4), number_at(frame, 8), number_at(frame, 12)};
  const std::size_t element = element_size(head.type);
  if (head.kind != ArrayHead::kArray || element == 0) return std::nullopt;
  if ((frame.size() - ArrayHead::kSize) / element != head.count) return std::nullopt;
  if ((frame.size() - ArrayHead::kSize) % element != 0) return std::nullopt;
  return head;
}

std::vector<Frame> frames_of(std::uint32_t id, Reply reply) {
  std::vector<Frame> frames(1);
  Json list = Json::array();
  for (ReplyArray& array : reply.arrays) {
    const ElementForm form = form_of(array.type);
    const std::size_t count = array.bytes.size() / form.size;
    if (count > kLargestId) return {failure_frame(id, "memory", "the result is too large for one message")};
    list.push_back({{"name", array.name}, {"type", form.name}, {"columns", array.columns}, {"count", count}});
    Frame frame;
    frame.is_text = false;
    frame.head = encode({ArrayHead::kArray, id, static_cast<std::uint32_t>(count), form.code});
    frame.body = std::move(array.bytes);
    frames.push_back(std::move(frame));
  }
  // The engine's text is an object with "ok" at least: the two keys go in front of its own.
  frames[0].head = concat("{\"id\":", id, ",\"arrays\":", dumped(list), ",", reply.text.substr(1));
  return frames;
}

Frame failure_frame(std::optional<std::uint32_t> id, std::string_view kind, std::string_view sentence) {
  Frame frame;
  frame.head = dumped({{"id", id ? Json(*id) : Json(nullptr)},
                       {"arrays", Json::array()},
                       {"ok", false},
                       {"kind", kind},
                       {"message", sentence}});
  return frame;
}

Frame progress_frame(std::uint32_t id, std::string_view stage, double fraction) {
  Frame frame;
  frame.may_be_dropped = true;
  frame.head = dumped({{"event", "progress"}, {"id", id}, {"stage", stage}, {"fraction", fraction}});
  return frame;
}

}  // namespace batten::studio
