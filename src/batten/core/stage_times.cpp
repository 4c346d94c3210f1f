#include "batten/core/stage_times.hpp"

namespace batten {

void StageTimes::add(std::string_view stage, double seconds) {
  for (auto& [name, total] : stages_) {
    if (name == stage) {
      total += seconds;
      return;
    }
  }
  stages_.emplace_back(stage, seconds);
}

void StageTimes::add(const StageTimes& others) {
  for (const auto& [name, seconds] : others.stages_) add(name, seconds);
}

double StageTimes::total() const {
  double sum = 0;
  for (const auto& [name, seconds] : stages_) sum += seconds;
  return sum;
}

ScopedStage::~ScopedStage() {
  times_.add(stage_, std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count());
}

}  // namespace batten
