#pragma once
#include "studio/service.hpp"

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/engine/reply.hpp"

namespace batten::studio {

/// What carries out messages; batten::Engine::handle, or a double in tests.
using Handle = std::function<Reply(std::string_view text, std::string_view bytes, const Progress&)>;
/// Makes one for every window.
using MakeHandle = std::function<Handle()>;
/// The engine of Batten.
Handle make_engine();

/// The engine of one window on a thread of its own: requests are carried out one after the other in their
/// order, and a cancel gets through while one runs.
class EngineThread : public Service {
 public:
  /// Requests that may wait, and the bytes among them.
  static constexpr std::size_t kMostWaiting = 64;
  static constexpr std::size_t kMostWaitingBytes = 2 * kMostFrame;
  /// Bytes on their way to the client before the next request is begun.
  static constexpr std::size_t kMostUnsent = kMostFrame;

  EngineThread(const MakeHandle& make, Hooks hooks);
  /// Stops what runs and waits for it.
  ~EngineThread() override;
  EngineThread(const EngineThread&) = delete;
  EngineThread& operator=(const EngineThread&) = delete;

  /// @param file is read when the request's turn comes.
  bool ask(Request request, OpenedBytes file) override;
  void cancel(std::uint32_t target) override;
  void sent(std::size_t n_bytes) override;
  /// Stops what runs; `ended` is the last that happens on the engine's thread.
  void close() override;

 private:
  void run(const MakeHandle& make);
  struct Waiting {
    Request request;
    OpenedBytes file;
  };
  bool wait_for_request(Waiting& next);
  void carry_out(const Handle& handle, Waiting& next);
  void send(std::vector<Frame> frames);

  Hooks hooks_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::size_t unsent_ = 0;
  std::uint32_t running_ = 0;  // meaningful while is_running_
  bool is_running_ = false;
  bool is_closed_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace batten::studio
