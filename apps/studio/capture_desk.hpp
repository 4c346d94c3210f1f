#pragma once
#include "studio/live_track.hpp"
#include "studio/service.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "batten/capture/preview.hpp"
#include "batten/pipeline/recorded_capture.hpp"

namespace batten::studio {

/// Captures for the windows of a studio: sources into recordings of the folder, replays, and scans of them,
/// as `batten capture`, `replay` and `convert` make them. One at a time; all windows follow it, each as fast
/// as it takes what it is sent, and a window that comes back finds it again. Messages:
/// docs/studio-server.md#capture.
class CaptureDesk {
 public:
  /// @param folder takes the recordings and outlives this; null: captures are refused.
  /// @param alone for which a capture goes on that no window follows.
  CaptureDesk(Folder* folder, std::chrono::milliseconds alone);
  ~CaptureDesk();
  CaptureDesk(const CaptureDesk&) = delete;
  CaptureDesk& operator=(const CaptureDesk&) = delete;

  /// The service of a window. It must not outlive this.
  std::unique_ptr<Service> window(Service::Hooks hooks);
  /// Asks what runs to end; does not wait.
  void stop();
  /// Ends what runs and waits for it; a recording is whole then. Nothing can be begun any more.
  void finish();

 private:
  enum class Doing { Nothing, Record, Replay, Convert };
  class WindowService;
  struct Window {
    Service::Hooks hooks;
    std::size_t unsent = 0;
    long seen = -1;  // the revision that it was told last
    int run = -1;
    int version = -1;  // of the track that it has
    std::size_t n_points = 0;
    double oldest_ms = 0;  // of what it was not told yet; 0: nothing
  };
  struct Run {
    int number = 0;
    std::string name;  // of the recording
    int file = 0;      // and its number in the folder
    std::string source;
    bool is_real_time = false;
    std::optional<PreviewState> state;
    LiveTrack track;
    double origin_ms = 0;
    std::string report, problem;  // JSON, a sentence
  };

  void ask(int window, const Request& request, OpenedBytes file);
  void begin(Doing doing, std::optional<Run> run, std::function<void()> work);
  void press(const std::string& key);
  void begin_recording(const std::string& text);
  void begin_replay(const std::string& text, OpenedBytes file);
  void begin_conversion(int window, const Request& request, OpenedBytes file);
  void record(const RecordedCaptureOptions& options, const std::string& name);
  CaptureHooks hooks();
  void update(const PreviewState& state);
  void end(const std::string& report, const std::string& problem);
  void work();
  void tell_windows();
  void tell(Window& window);
  void send(int window, std::vector<Frame> frames);

  Folder* folder_;
  std::chrono::milliseconds alone_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int, Window> windows_;
  int n_windows_ever_ = 0;
  std::chrono::steady_clock::time_point followed_;  // when the last window went
  Doing doing_ = Doing::Nothing;
  Run run_;
  long revision_ = 0;  // of both
  std::vector<std::string> keys_;
  std::function<void()> work_;  // what comes next
  bool is_closed_ = false;
  std::atomic<bool> stop_{false};
  std::thread worker_, teller_;  // last: they use all of the above
};

}  // namespace batten::studio
