#include "batten/capture/capture.hpp"

#include <algorithm>

#include "batten/capture/line_protocol.hpp"
#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr double kTurn = 0.05;  // seconds that a turn may wait for the source: keys wait as long
constexpr std::size_t kLatencies = 1000;
// So many lines of which none can be read are the wrong baud rate, or another program's output.
constexpr long kBabble = 20;

class Session {
 public:
  Session(Source& source, HostClock& clock, const RecordingHeader& header,
          const std::function<void(const std::vector<CaptureEvent>&)>& record, const CaptureOptions& options,
          const CaptureHooks& hooks)
      : source_(source),
        clock_(clock),
        record_(record),
        options_(options),
        hooks_(hooks),
        preview_(header),
        replays_(source.header() != nullptr) {}

  CaptureReport run() {
    source_.open();
    begin_us_ = lost_us_ = clock_.now_us();
    connected_ = true;
    tell("open");
    pass_on();
    while (report_.end.empty()) turn();
    tell("end");
    pass_on();
    source_.close();
    report_.seconds = seconds_since(begin_us_);
    std::vector<double> latencies(latencies_.begin(), latencies_.end());
    report_.latency_95_s = percentile(latencies, 0.95);
    report_.last = preview_.state();
    return report_;
  }

 private:
  double seconds_since(std::int64_t time) const { return static_cast<double>(clock_.now_us() - time) * 1e-6; }

  /// A replay tells the states of the recording, not its own.
  void tell(const std::string& state) {
    if (!replays_) events_.push_back({clock_.now_us(), "device", EventKind::State, state});
  }

  void turn() {
    if (hooks_.stop && hooks_.stop()) report_.end = "stopped";
    take_keys();
    if (connected_) {
      try {
        source_.poll(kTurn, events_);
      } catch (const SourceLost& lost) {
        lose(lost.what());
      }
      if (source_.state().kind == SourceState::Kind::Ended) report_.end = source_.state().reason;
    } else {
      reopen();
    }
    look_at_answers();
    pass_on();
    if (options_.seconds > 0 && seconds_since(begin_us_) >= options_.seconds)
      report_.end = "the time is over";
  }

  void take_keys() {
    if (!hooks_.keys) return;
    for (const std::string& key : hooks_.keys()) {
      if (key == "q")
        report_.end = "ended by q";
      else
        events_.push_back({clock_.now_us(), "keys", EventKind::Key, key});
    }
  }

  void lose(const std::string& reason) {
    source_.close();
    connected_ = false;
    next_open_us_ = clock_.now_us() + static_cast<std::int64_t>(options_.reopen_s * 1e6);
    if (answered_ && !awaited_) {
      tell("lost " + reason);
      lost_us_ = clock_.now_us();
      ++report_.n_losses;
      awaited_ = true;
    }
    last_reason_ = reason;
  }

  void reopen() {
    const double ahead = static_cast<double>(next_open_us_ - clock_.now_us()) * 1e-6;
    if (ahead > 0) {
      clock_.wait(std::min(ahead, kTurn));
      return;
    }
    try {
      source_.open();
      connected_ = true;
    } catch (const InvalidInput& error) {
      last_reason_ = error.what();
      next_open_us_ = clock_.now_us() + static_cast<std::int64_t>(options_.reopen_s * 1e6);
    }
  }

  /// Whether the device answers in a way that can be understood.
  void look_at_answers() {
    bool sensible = false;
    for (const CaptureEvent& event : events_) {
      if (event.kind == EventKind::Packet) {
        ++report_.n_answers;
        sensible = sensible || event.payload.size() == MorphoriderPacket::kBytes;
      } else if (event.kind == EventKind::Line) {
        ++report_.n_answers;
        if (!answered_ || awaited_) sensible = sensible || readable(event.payload);
      }
    }
    if (sensible && awaited_) {
      report_.seconds_lost += seconds_since(lost_us_);
      events_.push_back({clock_.now_us(), "device", EventKind::State, "back"});
      awaited_ = false;
    }
    answered_ = answered_ || sensible || replays_;
    if (answered_ || seconds_since(begin_us_) < options_.patience_s) return;
    if (n_unreadable_ >= kBabble) {
      pass_on();
      throw InvalidInput(
          concat("none of the first ", n_unreadable_,
                 " lines of the device can be read; is the baud rate right? Give it behind the "
                 "port, such as @230400"));
    }
    if (!last_reason_.empty()) {
      pass_on();
      throw InvalidInput(concat(last_reason_, "; is it switched on, and the right kind of source?"));
    }
  }

  bool readable(const std::string& line) {
    try {
      parse_line(line, false);
      return true;
    } catch (const InvalidInput&) {
      ++n_unreadable_;
      return false;
    }
  }

  void pass_on() {
    if (events_.empty()) return;
    report_.n_events += static_cast<long>(events_.size());
    if (record_) record_(events_);
    bool changed = false;
    for (const CaptureEvent& event : events_) changed = preview_.push(event) || changed;
    if (changed && hooks_.update) hooks_.update(preview_.state());
    for (const CaptureEvent& event : events_) {
      if (event.kind != EventKind::Packet && event.kind != EventKind::Line) continue;
      latencies_.push_back(seconds_since(event.time_us));
      report_.largest_latency_s = std::max(report_.largest_latency_s, latencies_.back());
      if (latencies_.size() > kLatencies) latencies_.pop_front();
    }
    events_.clear();
  }

  Source& source_;
  HostClock& clock_;
  const std::function<void(const std::vector<CaptureEvent>&)>& record_;
  const CaptureOptions& options_;
  const CaptureHooks& hooks_;
  LivePreview preview_;
  bool replays_;
  std::vector<CaptureEvent> events_;
  std::int64_t begin_us_ = 0, lost_us_ = 0, next_open_us_ = 0;
  bool connected_ = false;
  bool answered_ = false;  // something that can be read has come
  bool awaited_ = false;   // it was lost and has not answered since
  long n_unreadable_ = 0;
  std::string last_reason_;
  std::deque<double> latencies_;
  CaptureReport report_;
};

}  // namespace

std::optional<std::string> CaptureOptions::problem() const {
  if (!(seconds >= 0)) return concat("seconds must be at least 0, got ", seconds);
  if (!(patience_s > 0)) return concat("patience_s must be above 0, got ", patience_s);
  if (!(reopen_s > 0)) return concat("reopen_s must be above 0, got ", reopen_s);
  return std::nullopt;
}

CaptureReport capture(Source& source, HostClock& clock, const RecordingHeader& header,
                      const std::function<void(const std::vector<CaptureEvent>&)>& record,
                      const CaptureOptions& options, const CaptureHooks& hooks) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  return Session(source, clock, header, record, options, hooks).run();
}

}  // namespace batten
