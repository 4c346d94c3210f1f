#pragma once
#include <algorithm>
#include <ctime>
#include <string>
#include <string_view>

#include "batten/core/progress.hpp"

namespace batten::test {

/// Processor time of the calling thread, seconds: what other programs take of the processor does not count.
inline double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Listens to work and measures the longest stretch between two reports, and from the start and to the end,
/// as a share of the whole: no machine and no sanitizer changes that much. Work of 5 s that should report
/// every 100 ms has a share of 2 %.
class ReportGaps {
 public:
  template <typename Work>
  explicit ReportGaps(const Work& work) {
    const double start = thread_seconds();
    double last = start;
    const auto note = [&](std::string_view stage) {
      const double now = thread_seconds();
      if (now - last > longest_) {
        longest_ = now - last;
        before_ = stage;
      }
      last = thread_seconds();
    };
    const Progress progress([&](std::string_view stage, double) {
      note(stage);
      ++reports_;
      return true;
    });
    work(progress);
    note("the end");
    total_ = thread_seconds() - start;
  }

  double largest_share() const { return longest_ / std::max(total_, 1e-9); }
  int reports() const { return reports_; }
  /// The stage that was reported after the longest stretch, for messages of failure.
  const std::string& before() const { return before_; }

 private:
  double longest_ = 0, total_ = 0;
  int reports_ = 0;
  std::string before_;
};

}  // namespace batten::test
