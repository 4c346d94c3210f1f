#pragma once
#include "studio/folder.hpp"
#include "studio/frames.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace batten::studio {

/// What stands behind a socket and answers its messages. Called on the thread of the server.
class Service {
 public:
  struct Hooks {
    std::function<void(std::vector<Frame>)> send;  ///< called on any thread
    std::function<void()> ended;                   ///< called once; nothing is sent after it
  };

  virtual ~Service() = default;
  /// False where too much waits already. @param file what the request names by its number.
  virtual bool ask(Request request, OpenedBytes file) = 0;
  virtual void cancel(std::uint32_t target) = 0;
  /// Frames of so many bytes have left, or were dropped.
  virtual void sent(std::size_t n_bytes) = 0;
  /// Nothing is sent any more, and `ended` is called as soon as what runs has come to its end.
  virtual void close() = 0;
};

}  // namespace batten::studio
