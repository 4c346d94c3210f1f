#include "running.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>

#include "batten/core/error.hpp"

namespace batten::python {

namespace py = pybind11;

namespace {

constexpr std::chrono::milliseconds kBetweenLooks{20};
/// How long work that was told to stop is waited for: most of it reports more often.
constexpr std::chrono::milliseconds kPatience{60};

/// What the two threads share; the last of them to let go frees it.
struct Shared {
  std::function<void(const Progress&)> work;
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::condition_variable changed;
  bool finished = false, is_new = false;
  std::string stage;
  double fraction = 0;
  std::exception_ptr failure;
};

/// Threads whose work nobody waits for any more.
class LeftThreads {
 public:
  void join_all() {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (Entry& entry : entries_) entry.thread.join();
    entries_.clear();
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

LeftThreads& left_threads() {
  static LeftThreads left;
  return left;
}

void work_on(Shared& shared) {
  std::exception_ptr failure;
  try {
    shared.work(Progress([&shared](std::string_view stage, double fraction) {
      const std::lock_guard<std::mutex> lock(shared.mutex);
      shared.stage = stage;
      shared.fraction = fraction;
      shared.is_new = true;
      return !shared.stop.load();
    }));
  } catch (...) {
    failure = std::current_exception();
  }
  shared.work = nullptr;  // what it owns is freed here, not when the entry is noticed to be finished
  const std::lock_guard<std::mutex> lock(shared.mutex);
  shared.failure = failure;
  shared.finished = true;
  shared.changed.notify_one();
}

bool wait(Shared& shared, std::chrono::milliseconds time) {
  const py::gil_scoped_release released;
  std::unique_lock<std::mutex> lock(shared.mutex);
  return shared.changed.wait_for(lock, time, [&] { return shared.finished; });
}

/// @throws py::error_already_set, Cancelled.
void look_around(Shared& shared, const py::object& progress) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (progress.is_none()) return;
  std::string stage;
  double fraction = 0;
  {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    if (!shared.is_new) return;
    shared.is_new = false;
    stage = shared.stage;
    fraction = shared.fraction;
  }
  if (progress(stage, fraction).is(py::bool_(false))) throw Cancelled();
}

}  // namespace

void run_work(const py::object& progress, std::function<void(const Progress&)> work) {
  if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0)
    throw InvalidInput("progress must be None or a function of a stage and a fraction");
  const auto shared = std::make_shared<Shared>();
  shared->work = std::move(work);
  std::thread thread;
  try {
    thread = std::thread([shared] { work_on(*shared); });
  } catch (const std::system_error&) {  // no thread to be had
    const py::gil_scoped_release released;
    shared->work(Progress());
    return;
  }
  try {
    while (!wait(*shared, kBetweenLooks)) look_around(*shared, progress);
  } catch (...) {
    shared->stop = true;
    if (wait(*shared, kPatience))
      thread.join();
    else
      left_threads().take(std::move(thread), shared);
    throw;
  }
  thread.join();
  if (shared->failure) std::rethrow_exception(shared->failure);
}

void add_running(py::module_&) {
  // Before the statics go that the work uses: those of this module go later than its last Python.
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    const py::gil_scoped_release released;
    left_threads().join_all();
  }));
}

}  // namespace batten::python
