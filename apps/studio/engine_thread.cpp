#include "studio/engine_thread.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::studio {

namespace {

constexpr std::chrono::milliseconds kBetweenProgress{50};

std::size_t size_of(const Request& request) {
  return request.text.size() + request.bytes.size();
}

}  // namespace

EngineThread::EngineThread(const MakeHandle& make, Hooks hooks)
    : hooks_(std::move(hooks)), thread_([this, make] { run(make); }) {}

EngineThread::~EngineThread() {
  close();
  thread_.join();
}

bool EngineThread::ask(Request request, OpenedBytes file) {
  const std::lock_guard lock(mutex_);
  if (waiting_.size() >= kMostWaiting || waiting_bytes_ + size_of(request) > kMostWaitingBytes) return false;
  waiting_bytes_ += size_of(request);
  waiting_.push_back({std::move(request), std::move(file)});
  changed_.notify_all();
  return true;
}

void EngineThread::cancel(std::uint32_t target) {
  bool was_waiting = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_running_ && running_ == target) stop_ = true;
    const auto found = std::find_if(waiting_.begin(), waiting_.end(), [target](const Waiting& waiting) {
      return waiting.request.id == target;
    });
    if (found != waiting_.end()) {
      waiting_bytes_ -= size_of(found->request);
      waiting_.erase(found);
      was_waiting = true;
    }
  }
  if (was_waiting) send({failure_frame(target, "cancelled", "cancelled")});
}

void EngineThread::sent(std::size_t n_bytes) {
  const std::lock_guard lock(mutex_);
  unsent_ -= std::min(n_bytes, unsent_);
  changed_.notify_all();
}

void EngineThread::close() {
  const std::lock_guard lock(mutex_);
  is_closed_ = true;
  stop_ = true;
  changed_.notify_all();
}

void EngineThread::run(const MakeHandle& make) {
  {
    const Handle handle = make();
    for (Waiting next; wait_for_request(next); next = {}) carry_out(handle, next);
  }
  hooks_.ended();
}

bool EngineThread::wait_for_request(Waiting& next) {
  std::unique_lock lock(mutex_);
  is_running_ = false;
  // A client that does not take its results gets no new ones: memory stays bounded.
  changed_.wait(lock, [this] { return is_closed_ || (!waiting_.empty() && unsent_ < kMostUnsent); });
  if (is_closed_) return false;
  next = std::move(waiting_.front());
  waiting_.pop_front();
  waiting_bytes_ -= size_of(next.request);
  running_ = next.request.id;
  is_running_ = true;
  stop_ = false;
  return true;
}

void EngineThread::carry_out(const Handle& handle, Waiting& next) {
  Request& request = next.request;
  auto last = std::chrono::steady_clock::time_point{};
  const Progress progress([&](std::string_view stage, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last >= kBetweenProgress) {
      last = now;
      send({progress_frame(request.id, stage, fraction)});
    }
    return !stop_.load();
  });
  try {
    if (next.file.descriptor.is_open()) request.bytes = read_all(next.file);
    send(frames_of(request.id, handle(request.text, request.bytes, progress)));
  } catch (const Cancelled& error) {
    send({failure_frame(request.id, "cancelled", error.what())});
  } catch (const Error& error) {
    send({failure_frame(request.id, "error", error.what())});
  } catch (const std::bad_alloc&) {
    send({failure_frame(request.id, "memory", "there is not enough memory for this")});
  } catch (const std::exception& error) {
    send({failure_frame(request.id, "fault", concat("a fault of the program: ", error.what()))});
  }
}

void EngineThread::send(std::vector<Frame> frames) {
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_) return;
    for (const Frame& frame : frames) unsent_ += frame.size();
  }
  hooks_.send(std::move(frames));
}

}  // namespace batten::studio
