#include "studio/capture_desk.hpp"

#include "commands/capture.hpp"
#include "studio/capture_sources.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "batten/capture/decode.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/scan_io.hpp"

namespace batten::studio {

namespace {

using Json = nlohmann::ordered_json;

// A picture of a screen takes as long: more often nobody sees it.
constexpr std::chrono::milliseconds kBetweenNews{16};
constexpr std::chrono::seconds kBetweenLooks{1};  // whether anybody follows
constexpr double kMostSpeed = 1000;

double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string text_of(const Json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end() || !found->is_string())
    throw InvalidInput(concat("'", key, "' of the message must be a text"));
  return found->get<std::string>();
}

std::optional<double> number_of(const Json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end() || found->is_null()) return std::nullopt;
  if (!found->is_number()) throw InvalidInput(concat("'", key, "' of the message must be a number"));
  return found->get<double>();
}

Json json_of(const PreviewState& state) {
  return {{"seconds", static_cast<double>(state.time_us) * 1e-6},
          {"device", state.source},
          {"curves", state.n_curves},
          {"drawing", state.drawing},
          {"paused", state.paused},
          {"digits", state.digits},
          {"nodes", state.n_nodes},
          {"distance_m", state.distance_m},
          {"position", {state.position.x(), state.position.y(), state.position.z()}},
          {"placed", state.placed},
          {"drift_m", state.drift_m ? Json(*state.drift_m) : Json(nullptr)},
          {"drift_way_m", state.drift_way_m},
          {"drift_node", state.drift_node},
          {"rate_hz", state.rate_hz},
          {"jitter_s", state.jitter_s},
          {"readings", state.n_readings},
          {"refused", state.n_refused},
          {"missing", state.n_missing},
          {"gaps", state.n_gaps}};
}

ReplyArray array_of(std::string name, ElementType type, int columns, const void* data, std::size_t n_bytes) {
  ReplyArray array{std::move(name), type, columns, std::vector<std::byte>(n_bytes)};
  if (n_bytes > 0) std::memcpy(array.bytes.data(), data, n_bytes);
  return array;
}

}  // namespace

/// A window as the socket sees it.
class CaptureDesk::WindowService : public Service {
 public:
  WindowService(CaptureDesk& desk, int number) : desk_(desk), number_(number) {}
  ~WindowService() override { leave(); }

  bool ask(Request request, OpenedBytes file) override {
    desk_.ask(number_, request, std::move(file));
    return true;
  }
  void cancel(std::uint32_t /*target*/) override {}  // `stop` ends a capture
  void sent(std::size_t n_bytes) override {
    const std::lock_guard lock(desk_.mutex_);
    const auto found = desk_.windows_.find(number_);
    if (found == desk_.windows_.end()) return;
    found->second.unsent -= std::min(n_bytes, found->second.unsent);
    desk_.changed_.notify_all();
  }
  void close() override {
    if (const auto ended = leave()) ended();
  }

 private:
  std::function<void()> leave() {
    const std::lock_guard lock(desk_.mutex_);
    const auto found = desk_.windows_.find(number_);
    if (found == desk_.windows_.end()) return {};
    std::function<void()> ended = std::move(found->second.hooks.ended);
    desk_.windows_.erase(found);
    desk_.followed_ = std::chrono::steady_clock::now();
    return ended;
  }

  CaptureDesk& desk_;
  int number_;
};

CaptureDesk::CaptureDesk(Folder* folder, std::chrono::milliseconds alone)
    : folder_(folder), alone_(alone), worker_([this] { work(); }), teller_([this] { tell_windows(); }) {}

CaptureDesk::~CaptureDesk() {
  finish();
}

void CaptureDesk::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    stop_ = true;
    changed_.notify_all();
  }
  if (worker_.joinable()) worker_.join();
  if (teller_.joinable()) teller_.join();
}

std::unique_ptr<Service> CaptureDesk::window(Service::Hooks hooks) {
  const std::lock_guard lock(mutex_);
  const int number = n_windows_ever_++;
  windows_[number].hooks = std::move(hooks);
  changed_.notify_all();
  return std::make_unique<WindowService>(*this, number);
}

void CaptureDesk::stop() {
  const std::lock_guard lock(mutex_);
  stop_ = true;
}

// ---- messages --------------------------------------------------------------------------------------------

void CaptureDesk::ask(int window, const Request& request, OpenedBytes file) {
  try {
    const Json message = Json::parse(request.text);
    const std::string op = text_of(message, "op");
    Json answer = {{"ok", true}};
    if (op == "sources") {
      answer["sources"] = Json::array();
      for (const auto& [source, what] : offered_sources())
        answer["sources"].push_back({{"source", source}, {"what", what}});
      answer["recordings"] = Json::array();
      if (folder_ != nullptr)
        for (const ListedFile& listed : folder_->list().files)
          if (file_extension(listed.name) == "blog")
            answer["recordings"].push_back(
                {{"number", listed.number}, {"name", listed.name}, {"size", listed.size}});
      answer["folder"] = folder_ == nullptr ? Json(nullptr) : Json(folder_->name());
    } else if (op == "record") {
      begin_recording(request.text);
    } else if (op == "replay") {
      begin_replay(request.text, std::move(file));
    } else if (op == "key") {
      press(text_of(message, "key"));
    } else if (op == "stop") {
      stop();
    } else if (op == "convert") {
      return begin_conversion(window, request, std::move(file));
    } else {
      throw InvalidInput(
          concat("there is no op '", op, "'; there are sources, record, replay, key, stop and convert"));
    }
    send(window, frames_of(request.id, {dumped(answer), {}}));
  } catch (const Error& error) {
    send(window, {failure_frame(request.id, "error", error.what())});
  } catch (const std::exception& error) {  // on the server's thread: it would end for all
    send(window, {failure_frame(request.id, "fault", concat("a fault of the program: ", error.what()))});
  }
}

void CaptureDesk::begin(Doing doing, std::optional<Run> run, std::function<void()> work) {
  const std::lock_guard lock(mutex_);
  if (doing_ != Doing::Nothing)
    throw InvalidInput("the last capture, replay or conversion is not over; stop it first");
  if (run) {
    run->number = run_.number + 1;
    run_ = std::move(*run);
  }
  doing_ = doing;
  keys_.clear();
  stop_ = false;
  work_ = std::move(work);
  ++revision_;
  changed_.notify_all();
}

void CaptureDesk::press(const std::string& key) {
  static const std::set<std::string, std::less<>> known = {"+", "-", ".", "/", "*", "enter", "backspace"};
  const bool is_digit = key.size() == 1 && key[0] >= '0' && key[0] <= '9';
  if (!is_digit && known.count(key) == 0)
    throw InvalidInput(concat("'", key, "' is no key; there are + - 0 to 9 . / * enter and backspace"));
  const std::lock_guard lock(mutex_);
  if (doing_ != Doing::Record) throw InvalidInput("nothing is being recorded that the key could go to");
  keys_.push_back(key);
}

void CaptureDesk::begin_recording(const std::string& text) {
  const Json message = Json::parse(text);
  RecordedCaptureOptions options;
  options.source = text_of(message, "source");
  check_offered(options.source);
  const std::string name = text_of(message, "name");
  if (folder_ == nullptr)
    throw InvalidInput("batten studio was started without a folder to record into; start it with one");
  if (file_extension(name) != "blog" || name.ends_with(".gz"))
    throw InvalidInput("the name of a recording must end in .blog");
  options.recording = folder_->path(name);
  options.wheel_m = number_of(message, "wheel_m");
  if (const auto nodes = number_of(message, "nodes")) {
    if (!(*nodes >= 0 && *nodes <= 1e6)) throw InvalidInput("'nodes' must lie in [0, 1000000]");
    if (*nodes >= 1) options.n_nodes = static_cast<int>(*nodes);
  }
  if (message.contains("calibration"))
    options.calibration = commands::calibration_line(text_of(message, "calibration"), "the calibration");
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  {
    // Before the file is made: one that is refused leaves none behind.
    const std::lock_guard lock(mutex_);
    if (doing_ != Doing::Nothing) throw InvalidInput("the last capture is not over; stop it first");
  }
  const Written made = folder_->begin(name);
  if (made.outcome != Written::Outcome::Done) throw InvalidInput(made.sentence);
  const SourceSpec spec = parse_source(options.source);
  const auto speed = spec.options.find("speed");
  Run run;
  run.name = name;
  run.file = made.number;
  run.source = options.source;
  run.is_real_time = speed == spec.options.end() || speed->second == "1";
  begin(Doing::Record, std::move(run), [this, options, name] { record(options, name); });
}

void CaptureDesk::begin_replay(const std::string& text, OpenedBytes file) {
  const Json message = Json::parse(text);
  if (!file.descriptor.is_open()) throw InvalidInput("'file' must be the number of a recording");
  const double speed = number_of(message, "speed").value_or(1);
  if (!(speed >= 0 && speed <= kMostSpeed))
    throw InvalidInput(concat("'speed' must lie in [0, ", kMostSpeed, "], got ", speed));
  Run run;
  run.name = text_of(message, "name");
  run.file = message.at("file").get<int>();
  run.is_real_time = speed == 1;
  const auto opened = std::make_shared<OpenedBytes>(std::move(file));
  begin(Doing::Replay, std::move(run), [this, opened, speed, name = text_of(message, "name")] {
    try {
      const RecordedCapture result =
          replay_recording(parse_recording(read_all(*opened), name), speed, hooks());
      end(dumped({{"figures", commands::figures_of(result)}, {"warnings", result.warnings}}), {});
    } catch (const std::exception& error) {
      end({}, error.what());
    }
  });
}

void CaptureDesk::begin_conversion(int window, const Request& request, OpenedBytes file) {
  const std::string name = text_of(Json::parse(request.text), "name");
  if (!file.descriptor.is_open()) throw InvalidInput("'file' must be the number of a recording");
  const auto opened = std::make_shared<OpenedBytes>(std::move(file));
  begin(Doing::Convert, {}, [this, window, id = request.id, opened, name] {
    try {
      const DecodedRecording decoded = decode_recording(parse_recording(read_all(*opened), name));
      LogScan made = scan_from_recording(decoded);
      std::vector<std::string> warnings = decoded.warnings;
      warnings.insert(warnings.end(), made.warnings.begin(), made.warnings.end());
      const std::string text = format_rawnet(made.scan);
      Reply reply;
      reply.text = dumped({{"ok", true},
                           {"curves", made.scan.curves.size()},
                           {"readings", decoded.log.n_readings()},
                           {"warnings", warnings}});
      reply.arrays.push_back(array_of("file", ElementType::Uint8, 1, text.data(), text.size()));
      send(window, frames_of(id, std::move(reply)));
    } catch (const std::exception& error) {
      send(window, {failure_frame(id, "error", error.what())});
    }
  });
}

// ---- work ------------------------------------------------------------------------------------------------

void CaptureDesk::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return is_closed_ || work_; });
    if (!work_) return;
    const std::function<void()> next = std::exchange(work_, {});
    lock.unlock();
    next();
    lock.lock();
    doing_ = Doing::Nothing;
    ++revision_;
    changed_.notify_all();
  }
}

void CaptureDesk::record(const RecordedCaptureOptions& options, const std::string& name) {
  try {
    const RecordedCapture result = record_capture(options, hooks());
    end(dumped({{"figures", commands::figures_of(result)}, {"warnings", result.warnings}}), {});
  } catch (const std::exception& error) {
    bool is_empty = false;
    {
      const std::lock_guard lock(mutex_);
      is_empty = !run_.state || run_.state->n_readings == 0;
    }
    if (is_empty) folder_->take_back(name);  // its name is free for the next attempt
    end({}, is_empty ? error.what() : concat(error.what(), "; what came before is in ", name));
  }
}

CaptureHooks CaptureDesk::hooks() {
  CaptureHooks hooks;
  hooks.keys = [this] {
    const std::lock_guard lock(mutex_);
    return std::exchange(keys_, {});
  };
  hooks.stop = [this] { return stop_.load(); };
  hooks.update = [this](const PreviewState& state) { update(state); };
  return hooks;
}

void CaptureDesk::update(const PreviewState& state) {
  const double now = now_ms();
  const double since_begin = static_cast<double>(state.time_us) * 1e-3;
  const std::lock_guard lock(mutex_);
  // The clock of the capture beside that of the windows: nothing is told before it happens.
  if (!run_.state || now - since_begin < run_.origin_ms) run_.origin_ms = now - since_begin;
  for (auto& [number, window] : windows_)
    if (window.oldest_ms == 0) window.oldest_ms = run_.origin_ms + since_begin;
  run_.state = state;
  run_.track.push(state);
  ++revision_;
  changed_.notify_all();
}

void CaptureDesk::end(const std::string& report, const std::string& problem) {
  const std::lock_guard lock(mutex_);
  run_.report = report;
  run_.problem = problem;
}

// ---- news ------------------------------------------------------------------------------------------------

void CaptureDesk::tell_windows() {
  std::unique_lock lock(mutex_);
  while (!is_closed_) {
    changed_.wait_for(lock, kBetweenLooks, [this] {
      return is_closed_ || std::any_of(windows_.begin(), windows_.end(), [this](const auto& one) {
               return one.second.seen != revision_ && one.second.unsent == 0;
             });
    });
    if (windows_.empty()) {
      if (doing_ == Doing::Record && std::chrono::steady_clock::now() - followed_ > alone_) stop_ = true;
      continue;
    }
    for (auto& [number, window] : windows_)
      if (window.seen != revision_ && window.unsent == 0) tell(window);
    lock.unlock();
    std::this_thread::sleep_for(kBetweenNews);
    lock.lock();
  }
}

void CaptureDesk::tell(Window& window) {
  static const char* const kWords[] = {"nothing", "record", "replay", "convert"};
  if (window.run != run_.number || window.version != run_.track.version()) window.n_points = 0;
  window.run = run_.number;
  window.version = run_.track.version();
  window.seen = revision_;
  const std::size_t first = std::exchange(window.n_points, run_.track.n_points());
  const float* values = run_.track.values().data() + first * LiveTrack::kColumns;
  Json news = {{"ok", true}, {"event", "capture"}, {"doing", kWords[static_cast<int>(doing_)]}};
  news["name"] = run_.name;
  news["file"] = run_.file;
  news["source"] = run_.source;
  news["first"] = first;
  news["state"] = run_.state ? json_of(*run_.state) : Json(nullptr);
  news["sampled_ms"] = run_.is_real_time && window.oldest_ms > 0 ? Json(window.oldest_ms) : Json(nullptr);
  news["report"] = run_.report.empty() ? Json(nullptr) : Json::parse(run_.report);
  news["problem"] = run_.problem.empty() ? Json(nullptr) : Json(run_.problem);
  window.oldest_ms = 0;
  Reply reply;
  reply.text = dumped(news);
  reply.arrays.push_back(array_of("points", ElementType::Float32, LiveTrack::kColumns, values,
                                  (window.n_points - first) * LiveTrack::kColumns * sizeof(float)));
  std::vector<Frame> frames = frames_of(static_cast<std::uint32_t>(run_.number), std::move(reply));
  for (const Frame& frame : frames) window.unsent += frame.size();
  window.hooks.send(std::move(frames));
}

void CaptureDesk::send(int window, std::vector<Frame> frames) {
  const std::lock_guard lock(mutex_);
  const auto found = windows_.find(window);
  if (found == windows_.end()) return;
  for (const Frame& frame : frames) found->second.unsent += frame.size();
  found->second.hooks.send(std::move(frames));
}

}  // namespace batten::studio
