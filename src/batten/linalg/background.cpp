#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "batten/linalg/background_detail.hpp"

namespace batten::linalg_detail {

namespace {

constexpr std::chrono::milliseconds kBetweenReports{50};

/// What the two threads share; the last of them to let go frees it.
struct Shared {
  std::function<bool()> work;
  std::mutex mutex;
  std::condition_variable changed;
  bool finished = false, result = false;
  std::exception_ptr failure;
};

/// Threads whose work nobody waits for any more.
class LeftThreads {
 public:
  ~LeftThreads() {
    for (Entry& entry : entries_) entry.thread.join();
  }
  void take(std::thread thread, std::shared_ptr<Shared> shared) {
    const std::lock_guard<std::mutex> lock(mutex_);
    entries_.remove_if([](Entry& entry) {
      {
        const std::lock_guard<std::mutex> entry_lock(entry.shared->mutex);
        if (!entry.shared->finished) return false;
      }
      entry.thread.join();
      return true;
    });
    entries_.push_back({std::move(thread), std::move(shared)});
  }

 private:
  struct Entry {
    std::thread thread;
    std::shared_ptr<Shared> shared;
  };
  std::mutex mutex_;
  std::list<Entry> entries_;
};

void work_on(Shared& shared) {
  bool result = false;
  std::exception_ptr failure;
  try {
    result = shared.work();
  } catch (...) {
    failure = std::current_exception();
  }
  shared.work = nullptr;  // what it owns is freed here, not when the entry is noticed to be finished
  const std::lock_guard<std::mutex> lock(shared.mutex);
  shared.result = result;
  shared.failure = failure;
  shared.finished = true;
  shared.changed.notify_one();
}

}  // namespace

bool run_in_background(std::function<bool()> work, const Progress& progress) {
  static LeftThreads left;
  const auto shared = std::make_shared<Shared>();
  shared->work = std::move(work);
  std::thread thread;
  try {
    thread = std::thread([shared] { work_on(*shared); });
  } catch (const std::system_error&) {
    return shared->work();  // no thread to be had
  }
  std::unique_lock<std::mutex> lock(shared->mutex);
  while (!shared->changed.wait_for(lock, kBetweenReports, [&] { return shared->finished; })) {
    lock.unlock();
    try {
      progress.report("factorisation", 0);
    } catch (...) {
      left.take(std::move(thread), shared);
      throw;
    }
    lock.lock();
  }
  lock.unlock();
  thread.join();
  if (shared->failure) std::rethrow_exception(shared->failure);
  return shared->result;
}

}  // namespace batten::linalg_detail
