#include "batten/core/parallel.hpp"

#include <algorithm>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/processors.hpp"
#include "batten/core/text.hpp"

#ifndef __EMSCRIPTEN__
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#endif

namespace batten {

namespace {

using Body = std::function<void(Eigen::Index begin, Eigen::Index end)>;

void run_serially(Eigen::Index n, Eigen::Index grain, const Body& body, const Progress* progress) {
  for (Eigen::Index begin = 0; begin < n; begin += grain) {
    if (progress != nullptr) progress->report("working", static_cast<double>(begin) / static_cast<double>(n));
    body(begin, std::min(n, begin + grain));
  }
}

#ifndef __EMSCRIPTEN__
std::atomic<int> requested_threads{0};  ///< 0: all that the process may use
thread_local bool inside_loop = false;  ///< the loops inside a loop run where they are

/// The chunks of one loop, taken one by one by whoever is free.
class Loop {
 public:
  Loop(Eigen::Index n, Eigen::Index grain, const Body& body)
      : n_(n), grain_(grain), n_chunks_((n + grain - 1) / grain), body_(body) {}

  void run(Eigen::Index n_threads, const Progress* progress) {
    std::vector<std::thread> threads;
    threads.reserve(static_cast<std::size_t>(n_threads - 1));
    try {
      for (Eigen::Index t = 1; t < n_threads; ++t) threads.emplace_back([this] { work(nullptr); });
    } catch (const std::system_error&) {
      // No more threads to be had: those that there are do it.
    }
    work(progress);
    for (std::thread& thread : threads) thread.join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void work(const Progress* progress) {
    inside_loop = true;
    for (Eigen::Index c = next_++; c < n_chunks_; c = next_++) {
      try {
        if (progress != nullptr)
          progress->report("working", static_cast<double>(c) / static_cast<double>(n_chunks_));
        body_(c * grain_, std::min(n_, (c + 1) * grain_));
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex_);
        // Chunks are taken in their order: of several failures the first is always among those that ran.
        if (!failure_ || c < failed_chunk_) {
          failure_ = std::current_exception();
          failed_chunk_ = c;
        }
        next_ = n_chunks_;
      }
    }
    inside_loop = false;
  }

  const Eigen::Index n_, grain_, n_chunks_;
  const Body& body_;
  std::atomic<Eigen::Index> next_{0};
  std::exception_ptr failure_;
  Eigen::Index failed_chunk_ = 0;
  std::mutex failure_mutex_;
};
#endif

void run(Eigen::Index n, Eigen::Index grain, const Body& body, const Progress* progress) {
  grain = std::max<Eigen::Index>(grain, 1);
#ifndef __EMSCRIPTEN__
  const Eigen::Index n_threads = std::min<Eigen::Index>((n + grain - 1) / grain, thread_count());
  if (n_threads > 1 && !inside_loop) {
    Loop(n, grain, body).run(n_threads, progress);
    return;
  }
#endif
  run_serially(n, grain, body, progress);
}

}  // namespace

#ifdef __EMSCRIPTEN__
int thread_count() {
  return 1;
}
void set_thread_count(int n) {
  if (n < 0) throw InvalidInput(concat("the number of threads must be at least 1, got ", n));
}
#else
int thread_count() {
  static const int available = available_processors();
  const int requested = requested_threads.load();
  return requested > 0 ? requested : available;
}
void set_thread_count(int n) {
  if (n < 0) throw InvalidInput(concat("the number of threads must be at least 1, got ", n));
  requested_threads = n;
}
#endif

void parallel_for(Eigen::Index n, Eigen::Index grain, const Body& body) {
  run(n, grain, body, nullptr);
}

void parallel_for(Eigen::Index n, Eigen::Index grain, const Body& body, const Progress& progress) {
  run(n, grain, body, &progress);
}

double parallel_sum(Eigen::Index n, Eigen::Index grain,
                    const std::function<double(Eigen::Index begin, Eigen::Index end)>& body) {
  grain = std::max<Eigen::Index>(grain, 1);
  std::vector<double> sums(static_cast<std::size_t>((n + grain - 1) / grain));
  parallel_for(n, grain, [&](Eigen::Index begin, Eigen::Index end) {
    sums[static_cast<std::size_t>(begin / grain)] = body(begin, end);
  });
  double sum = 0;
  for (const double part : sums) sum += part;
  return sum;
}

}  // namespace batten
