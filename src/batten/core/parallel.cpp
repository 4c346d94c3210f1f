#include "batten/core/parallel.hpp"

#include <algorithm>

#ifndef __EMSCRIPTEN__
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#endif

namespace batten {

void parallel_for(Eigen::Index n, Eigen::Index grain,
                  const std::function<void(Eigen::Index begin, Eigen::Index end)>& body) {
  grain = std::max<Eigen::Index>(grain, 1);
  const Eigen::Index n_chunks = (n + grain - 1) / grain;
#ifdef __EMSCRIPTEN__
  for (Eigen::Index c = 0; c < n_chunks; ++c) body(c * grain, std::min(n, (c + 1) * grain));
#else
  const Eigen::Index n_threads =
      std::min<Eigen::Index>(n_chunks, std::max(1U, std::thread::hardware_concurrency()));
  if (n_threads <= 1) {
    for (Eigen::Index c = 0; c < n_chunks; ++c) body(c * grain, std::min(n, (c + 1) * grain));
    return;
  }
  std::atomic<Eigen::Index> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (Eigen::Index c = next++; c < n_chunks; c = next++) {
      try {
        body(c * grain, std::min(n, (c + 1) * grain));
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = n_chunks;
      }
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(n_threads - 1);
  for (Eigen::Index t = 1; t < n_threads; ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
#endif
}

}  // namespace batten
