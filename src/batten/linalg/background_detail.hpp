#pragma once
#include <functional>

#include "batten/core/progress.hpp"

namespace batten::linalg_detail {

/// Runs work that cannot be interrupted on a thread of its own, while the calling thread reports every 50 ms.
/// When it is cancelled, the thread is left to itself: `work` must own all that it uses. The process joins
/// threads left so when it exits. An exception of `work` is rethrown.
/// @return what `work` returned. @throws Cancelled.
bool run_in_background(std::function<bool()> work, const Progress& progress);

}  // namespace batten::linalg_detail
