#include "studio/frames.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace {

using namespace batten::studio;

/// What a reader gives for one frame: at most two messages, requests with the bytes that they announced.
void check(const std::vector<Incoming>& complete) {
  if (complete.size() > 2) std::abort();
  for (const Incoming& incoming : complete)
    if (const auto* problem = std::get_if<Problem>(&incoming);
        problem != nullptr && problem->sentence.empty())
      std::abort();
}

}  // namespace

/// Lines are frames of a client: the first letter says whether binary (b) or text. Whatever they hold, each
/// is a message, part of one, or a sentence. As a frame of the server, each is an array as long as it says,
/// or none.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string all(data, data + size);
  FrameReader reader;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find('\n', at), all.size());
    const std::string frame = all.substr(at, end - at);
    const bool is_binary = !frame.empty() && frame[0] == 'b';
    const std::string payload = frame.empty() ? frame : frame.substr(1);
    check(is_binary ? reader.binary(payload) : reader.text(payload));
    at = end + 1;
  }
  if (const auto head = decode_array(all)) {
    const std::size_t element = head->type == 3 ? 1 : 4;
    if (ArrayHead::kSize + element * head->count != all.size()) std::abort();
    if (encode(*head) != all.substr(0, ArrayHead::kSize)) std::abort();
  }
  return 0;
}
