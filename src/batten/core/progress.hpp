#pragma once
#include <functional>
#include <string_view>
#include <utility>

#include "batten/core/error.hpp"

namespace batten {

/// Carries progress out of long work and the wish to stop into it. A default-constructed one is silent.
class Progress {
 public:
  /// Told the stage and the fraction done of it (0..1); returns false to stop the work.
  using Callback = std::function<bool(std::string_view stage, double fraction)>;

  Progress() = default;
  explicit Progress(Callback callback) : callback_(std::move(callback)) {}

  /// Called by the work, often. @throws Cancelled when the callback asks to stop.
  void report(std::string_view stage, double fraction) const {
    if (callback_ && !callback_(stage, fraction)) throw Cancelled();
  }

 private:
  Callback callback_;
};

}  // namespace batten
