#pragma once
#include <functional>
#include <string>
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

  /// Called by the work, often, always from the thread that called the work. @throws Cancelled when the
  /// callback asks to stop.
  void report(std::string_view stage, double fraction) const {
    if (callback_ && !callback_(stage, fraction)) throw Cancelled();
  }

  /// Whether nobody listens.
  bool is_silent() const { return !callback_; }

  /// For a part of a stage: what it is told, under any name and from 0 to 1, is passed on as `stage` from
  /// `from` to `to`. Must not outlive this object.
  Progress part(std::string_view stage, double from, double to) const {
    if (is_silent()) return {};
    return Progress([this, stage = std::string(stage), from, to](std::string_view, double fraction) {
      return callback_(stage, from + (to - from) * fraction);
    });
  }

 private:
  Callback callback_;
};

}  // namespace batten
