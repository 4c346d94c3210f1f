#include "batten/core/background_work.hpp"

#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <system_error>
#include <utility>

namespace batten {

struct BackgroundWork::State {
  std::function<void()> work;
  std::mutex mutex;
  std::condition_variable changed;
  bool is_done = false;
  std::exception_ptr failure;

  void run() {
    std::exception_ptr thrown;
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    work = nullptr;  // what it owns is freed here, not when somebody notices that it is done
    const std::lock_guard lock(mutex);
    failure = std::move(thrown);
    is_done = true;
    changed.notify_all();
  }
};

namespace {

/// Threads whose work nobody waits for any more; those that are done are joined when another comes.
class LeftThreads {
 public:
  ~LeftThreads() { join_all(); }
  void join_all() {
    const std::lock_guard lock(mutex_);
    for (Entry& entry : entries_) entry.thread.join();
    entries_.clear();
  }
  void take(std::thread thread, std::function<bool()> is_done) {
    const std::lock_guard lock(mutex_);
    entries_.remove_if([](Entry& entry) {
      if (!entry.is_done()) return false;
      entry.thread.join();
      return true;
    });
    entries_.push_back({std::move(thread), std::move(is_done)});
  }

 private:
  struct Entry {
    std::thread thread;
    std::function<bool()> is_done;
  };
  std::mutex mutex_;
  std::list<Entry> entries_;
};

/// Made when it is first needed: later than most that such work uses, and so gone earlier.
LeftThreads& left_threads() {
  static LeftThreads left;
  return left;
}

}  // namespace

BackgroundWork::BackgroundWork(std::function<void()> work) : state_(std::make_shared<State>()) {
  state_->work = std::move(work);
  try {
    thread_ = std::thread([state = state_] { state->run(); });
  } catch (const std::system_error&) {
    state_->run();
  }
}

BackgroundWork::~BackgroundWork() {
  if (!thread_.joinable()) return;
  if (wait(std::chrono::milliseconds(0)))
    thread_.join();
  else
    left_threads().take(std::move(thread_), [state = state_] {
      const std::lock_guard lock(state->mutex);
      return state->is_done;
    });
}

bool BackgroundWork::wait(std::chrono::milliseconds time) {
  std::unique_lock lock(state_->mutex);
  return state_->changed.wait_for(lock, time, [&] { return state_->is_done; });
}

void BackgroundWork::finish() {
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(state_->mutex);
  if (state_->failure) std::rethrow_exception(state_->failure);
}

void BackgroundWork::join_left() {
  left_threads().join_all();
}

}  // namespace batten
