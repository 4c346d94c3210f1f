#include <utility>

#include "batten/core/error.hpp"
#include "batten/scan/length_model_detail.hpp"

namespace batten {

namespace {

/// By how much −2 log likelihood must fall: odds of twenty to one.
constexpr double kClearly = 6;

struct LengthKind {
  double scale_deviation, speed_deviation;
  const char* words;
};
/// A hand whose speed is 20 % off now here, now there, on a piece of one size, changes by some 0.4.
constexpr LengthKind kLengthKinds[] = {
    {kEstimatedLengths, 0, "one factor per curve"},
    {0, 0, "as measured by an odometer"},
    {kEstimatedLengths, 0.13, "a speed that changes slightly along each curve"},
    {kEstimatedLengths, 0.4, "a speed that changes along each curve"},
    {kEstimatedLengths, 1.2, "a speed that changes much along each curve"}};

}  // namespace

LengthModel choose_length_model(const SampledScan& scan, JointOptions options, const Progress& progress) {
  LengthModel best;
  for (const LengthKind& kind : kLengthKinds) {
    options.scale_deviation = kind.scale_deviation;
    options.speed_deviation = kind.speed_deviation;
    const bool is_first = &kind == kLengthKinds;
    try {
      JointEstimate estimate = estimate_jointly(scan, options, progress);
      if (!is_first && !(estimate.cost < best.estimate.cost - kClearly)) continue;
      best = {kind.scale_deviation, kind.speed_deviation, std::move(estimate), kind.words};
    } catch (const SolverFailure&) {
      if (is_first) throw;
    }
  }
  return best;
}

}  // namespace batten
