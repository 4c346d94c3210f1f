#include <algorithm>
#include <cmath>

#include "batten/capture/line_protocol.hpp"
#include "batten/capture/morphorider.hpp"
#include "batten/capture/source.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr std::int64_t kRequestInterval = 10000;  // microseconds
constexpr double kAnswerWithin = 0.05;
constexpr double kSilenceAfterShort = 0.02;
// A device that babbles never falls silent; then it is asked again all the same.
constexpr double kLongestDrain = 0.2;
constexpr int kFailuresOfSilence = 3;

/// Patience is with the computer, too: where the clock runs faster than real time it is as long in real time.
double patient(double seconds, const HostClock& clock) {
  const double real = clock.real_seconds();
  return real > 0 && real < 1 ? seconds / real : seconds;
}

class MorphoriderSource : public Source {
 public:
  MorphoriderSource(StreamOpener open_stream, HostClock& clock)
      : open_stream_(std::move(open_stream)), clock_(clock) {}

  void open() override {
    stream_ = open_stream_();
    failures_ = 0;
    next_request_us_ = clock_.now_us();
  }

  void poll(double seconds, std::vector<CaptureEvent>& events) override {
    const std::int64_t now = clock_.now_us();
    const double ahead = static_cast<double>(next_request_us_ - now) * 1e-6;
    if (ahead > seconds) {
      clock_.wait(seconds);
      return;
    }
    clock_.wait(ahead);
    stream_->read(0);  // nothing may be left of earlier answers
    const std::int64_t asked = clock_.now_us();
    next_request_us_ = std::max(next_request_us_ + kRequestInterval, asked);
    stream_->write(std::string(1, MorphoriderPacket::kRequest));
    std::string answer;
    // In whole microseconds: a rest that rounds to none would never pass.
    const std::int64_t deadline = asked + std::llround(patient(kAnswerWithin, clock_) * 1e6);
    for (std::int64_t now_us = asked; answer.size() < MorphoriderPacket::kBytes && now_us < deadline;
         now_us = clock_.now_us())
      answer += stream_->read(static_cast<double>(deadline - now_us) * 1e-6);
    if (answer.size() == MorphoriderPacket::kBytes) {
      events.push_back({asked, "device", EventKind::Packet, std::move(answer)});
      failures_ = 0;
      return;
    }
    if (!answer.empty()) events.push_back({asked, "device", EventKind::Packet, std::move(answer)});
    drain();
    if (++failures_ >= kFailuresOfSilence)
      throw SourceLost("the device is silent: it does not answer 'Q' with 22 bytes");
  }

  void close() override { stream_.reset(); }
  SourceState state() const override {
    return {stream_ ? SourceState::Kind::Open : SourceState::Kind::Closed, {}};
  }

 private:
  void drain() {
    const std::int64_t begin = clock_.now_us();
    while (!stream_->read(patient(kSilenceAfterShort, clock_)).empty() &&
           static_cast<double>(clock_.now_us() - begin) * 1e-6 < patient(kLongestDrain, clock_)) {
    }
  }

  StreamOpener open_stream_;
  HostClock& clock_;
  std::unique_ptr<ByteStream> stream_;
  std::int64_t next_request_us_ = 0;
  int failures_ = 0;
};

class LineSource : public Source {
 public:
  LineSource(StreamOpener open_stream, HostClock& clock, double longest_silence)
      : open_stream_(std::move(open_stream)), clock_(clock), longest_silence_(longest_silence) {}

  void open() override {
    stream_ = open_stream_();
    splitter_ = LineSplitter();
    last_line_us_ = clock_.now_us();
    stream_->write("?\nstart\n");
  }

  void poll(double seconds, std::vector<CaptureEvent>& events) override {
    const std::string bytes = stream_->read(seconds);
    const std::int64_t now = clock_.now_us();
    for (std::string& line : splitter_.push(bytes)) {
      last_line_us_ = now;
      events.push_back({now, "device", EventKind::Line, std::move(line)});
    }
    if (longest_silence_ > 0 && static_cast<double>(now - last_line_us_) * 1e-6 > longest_silence_)
      throw SourceLost(concat("the device is silent: no line for ", longest_silence_, " s"));
  }

  void close() override { stream_.reset(); }
  SourceState state() const override {
    return {stream_ ? SourceState::Kind::Open : SourceState::Kind::Closed, {}};
  }

 private:
  StreamOpener open_stream_;
  HostClock& clock_;
  double longest_silence_;
  std::unique_ptr<ByteStream> stream_;
  LineSplitter splitter_;
  std::int64_t last_line_us_ = 0;
};

class ReplaySource : public Source {
 public:
  ReplaySource(Recording recording, HostClock& clock) : recording_(std::move(recording)), clock_(clock) {}

  void open() override { open_ = true; }

  void poll(double seconds, std::vector<CaptureEvent>& events) override {
    if (next_ == recording_.events.size()) return;
    const std::int64_t due = recording_.events[next_].time_us;
    clock_.wait(std::min(seconds, static_cast<double>(due - clock_.now_us()) * 1e-6));
    const std::int64_t now = clock_.now_us();
    // In the order of the file, whatever the times: what is replayed is the same recording.
    while (next_ < recording_.events.size() && recording_.events[next_].time_us <= now)
      events.push_back(recording_.events[next_++]);
  }

  void close() override { open_ = false; }
  SourceState state() const override {
    if (next_ == recording_.events.size()) return {SourceState::Kind::Ended, "the recording is over"};
    return {open_ ? SourceState::Kind::Open : SourceState::Kind::Closed, {}};
  }
  const RecordingHeader* header() const override { return &recording_.header; }

 private:
  Recording recording_;
  HostClock& clock_;
  std::size_t next_ = 0;
  bool open_ = false;
};

}  // namespace

std::unique_ptr<Source> make_morphorider_source(StreamOpener open_stream, HostClock& clock) {
  return std::make_unique<MorphoriderSource>(std::move(open_stream), clock);
}

std::unique_ptr<Source> make_line_source(StreamOpener open_stream, HostClock& clock, double longest_silence) {
  return std::make_unique<LineSource>(std::move(open_stream), clock, longest_silence);
}

std::unique_ptr<Source> make_replay_source(Recording recording, HostClock& clock) {
  return std::make_unique<ReplaySource>(std::move(recording), clock);
}

}  // namespace batten
