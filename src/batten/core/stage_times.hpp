#pragma once
#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace batten {

/// Seconds spent per named stage, in the order in which the stages first ran. Time of a stage that runs
/// again is added up.
class StageTimes {
 public:
  /// Adds to one stage, in seconds, or all the stages of others.
  void add(std::string_view stage, double seconds);
  void add(const StageTimes& others);
  /// Of all stages, seconds.
  double total() const;
  const std::vector<std::pair<std::string, double>>& stages() const { return stages_; }

 private:
  std::vector<std::pair<std::string, double>> stages_;
};

/// Adds the time of its own life to a stage.
class ScopedStage {
 public:
  /// The time of `stage` in `times` begins. @pre `times` outlives this.
  ScopedStage(StageTimes& times, std::string_view stage)
      : times_(times), stage_(stage), start_(std::chrono::steady_clock::now()) {}
  ~ScopedStage();
  ScopedStage(const ScopedStage&) = delete;
  ScopedStage& operator=(const ScopedStage&) = delete;

 private:
  StageTimes& times_;
  std::string stage_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace batten
