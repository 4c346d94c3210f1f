#include "running.hpp"

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "batten/core/background_work.hpp"
#include "batten/core/error.hpp"

namespace batten::python {

namespace py = pybind11;

namespace {

constexpr std::chrono::milliseconds kBetweenLooks{20};
/// How long work that was told to stop is waited for: most of it reports more often.
constexpr std::chrono::milliseconds kPatience{60};

/// What the two threads tell each other.
struct Shared {
  std::atomic<bool> stop{false};
  std::mutex mutex;
  bool is_new = false;
  std::string stage;
  double fraction = 0;

  bool report(std::string_view now, double share) {
    const std::lock_guard<std::mutex> lock(mutex);
    stage = now;
    fraction = share;
    is_new = true;
    return !stop.load();
  }
};

bool wait(BackgroundWork& background, std::chrono::milliseconds time) {
  const py::gil_scoped_release released;
  return background.wait(time);
}

/// @throws py::error_already_set, Cancelled.
void look_around(Shared& shared, const py::object& progress) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (progress.is_none()) return;
  std::string stage;
  double fraction = 0;
  {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    if (!shared.is_new) return;
    shared.is_new = false;
    stage = shared.stage;
    fraction = shared.fraction;
  }
  if (progress(stage, fraction).is(py::bool_(false))) throw Cancelled();
}

}  // namespace

void run_work(const py::object& progress, std::function<void(const Progress&)> work) {
  if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0)
    throw InvalidInput("progress must be None or a function of a stage and a fraction");
  const auto shared = std::make_shared<Shared>();
  std::optional<BackgroundWork> background;
  {
    const py::gil_scoped_release released;  // it may have to do the work itself
    background.emplace([shared, work = std::move(work)] {
      work(
          Progress([&](std::string_view stage, double fraction) { return shared->report(stage, fraction); }));
    });
  }
  try {
    while (!wait(*background, kBetweenLooks)) look_around(*shared, progress);
  } catch (...) {
    shared->stop = true;
    wait(*background, kPatience);
    throw;
  }
  background->finish();
}

void add_running(py::module_&) {
  // Before the statics go that the work uses: those of this module go later than its last Python.
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    const py::gil_scoped_release released;
    BackgroundWork::join_left();
  }));
}

}  // namespace batten::python
