#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <pybind11/pybind11.h>

#include "batten/core/progress.hpp"

namespace batten::python {

/// Runs work on a thread of its own, without the lock of the interpreter, while the calling thread looks
/// every 20 ms for signals and tells `progress` (a callable of stage and fraction, or None) what is new.
///
/// When a signal handler or `progress` raises, or `progress` returns False, the work is told to stop at its
/// next report. Where that does not come within a tenth of a second (a factorisation, a file) its thread is
/// left to itself: `work` must own all that it uses and holds nothing of Python. The interpreter waits for
/// threads left so when it ends.
/// @throws what the work throws; py::error_already_set; Cancelled.
void run_work(const pybind11::object& progress, std::function<void(const Progress&)> work);

/// The same for work with a result.
template <typename Work>
auto running(const pybind11::object& progress, Work work) {
  using Result = decltype(work(std::declval<const Progress&>()));
  const auto result = std::make_shared<std::optional<Result>>();
  // Shared, because a std::function is copied and inputs need not be.
  const auto kept = std::make_shared<Work>(std::move(work));
  run_work(progress, [result, kept](const Progress& reports) { result->emplace((*kept)(reports)); });
  return std::move(**result);
}

/// Lets the interpreter wait, when it ends, for threads that run_work() has left.
void add_running(pybind11::module_& module);

}  // namespace batten::python
