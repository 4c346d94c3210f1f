#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

namespace batten {

/// Work on a thread of its own that its caller looks in on. Work that is not done when this goes is left to
/// itself: it must own all that it uses. Where the system has no thread to give, the constructor does the
/// work itself.
class BackgroundWork {
 public:
  /// Starts at once.
  explicit BackgroundWork(std::function<void()> work);
  ~BackgroundWork();
  BackgroundWork(const BackgroundWork&) = delete;
  BackgroundWork& operator=(const BackgroundWork&) = delete;

  /// Waits until the work is done, at most so long. @return whether it is.
  bool wait(std::chrono::milliseconds time);
  /// Waits to the end. @throws what the work threw.
  void finish();

  /// Waits for all work that was left to itself. The process does so when it exits; whoever must be earlier,
  /// calls it.
  static void join_left();

 private:
  struct State;
  std::shared_ptr<State> state_;  // the last of the two threads to let go frees it
  std::thread thread_;
};

}  // namespace batten
