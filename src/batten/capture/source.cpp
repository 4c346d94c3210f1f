#include "batten/capture/source.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "batten/capture/pseudo_terminal.hpp"
#include "batten/capture/simulated_device.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {

namespace {

constexpr const char* kForms =
    "morphorider:/dev/…, line:/dev/…[@230400], ws://[ADDRESS][:PORT], udp:[ADDRESS:]PORT, file:RECORDING, "
    "simulator:SHAPE[?option=value&…]";
constexpr int kMorphoriderBaud = 115200;
constexpr int kLineBaud = 115200;
constexpr int kWebSocketPort = 8765;
constexpr double kLineSilence = 5;
constexpr const char* kLoopback = "127.0.0.1";
// Readings of a motion, as a fraction of the diameter: fine enough that turning evenly between them is exact
// to the rounding of the sensors.
constexpr double kMotionStep = 0.003;

double number_option(const std::string& key, const std::string& text) {
  double value = 0;
  try {
    value = text.find('%') != std::string::npos ? parse_fraction(text) : 0;
  } catch (const InvalidInput&) {
    throw InvalidInput(concat("the option ", key, "=", text, " of the source is no number"));
  }
  if (text.find('%') != std::string::npos) return value;
  if (!parse_number(text, value) || !std::isfinite(value))
    throw InvalidInput(concat("the option ", key, "=", text, " of the source is no number"));
  return value;
}

/// "5:2": from second 5 for 2 seconds.
FaultSpan span_option(const std::string& key, const std::string& text) {
  const std::vector<std::string_view> parts = split_fields(text, ':');
  FaultSpan span;
  if (parts.size() < 2 || !parse_number(parts[0], span.start) || !parse_number(parts[1], span.duration) ||
      !(span.start >= 0) || !(span.duration >= 0) || !(span.start + span.duration < 1e9))
    throw InvalidInput(
        concat("the option ", key, "=", text, " of the source is no START:DURATION in seconds"));
  return span;
}

double length_option(const std::string& text) {
  const Length length = parse_length(text);
  if (length.kind == Length::Kind::Relative || !(length.value > 0))
    throw InvalidInput(concat("'", text, "' is no length above 0, such as 0.3m"));
  return length.value;
}

/// The options of a simulator, each used up.
struct SimulatorOptions {
  SimulatedDeviceOptions device;
  MotionOptions motion;
  double size_m = 0.3;
};

SimulatorOptions simulator_options(std::map<std::string, std::string> options) {
  SimulatorOptions result;
  SimulatedDeviceOptions& device = result.device;
  const std::map<std::string, std::function<void(const std::string&)>> known = {
      {"device",
       [&](const std::string& v) {
         if (v != "morphorider" && v != "line")
           throw InvalidInput(concat("device=", v, " is unknown; choose morphorider or line"));
         device.kind =
             v == "line" ? SimulatedDeviceOptions::Kind::Line : SimulatedDeviceOptions::Kind::Morphorider;
       }},
      {"form", [&](const std::string& v) { device.form = parse_choice<PacketForm>(v); }},
      {"rate", [&](const std::string& v) { device.rate_hz = number_option("rate", v); }},
      {"fused", [&](const std::string& v) { device.fused = v != "0"; }},
      {"wheel", [&](const std::string& v) { device.wheel_m = length_option(v); }},
      {"noise", [&](const std::string& v) { device.noise = number_option("noise", v); }},
      {"distortion", [&](const std::string& v) { device.distortion = v != "0"; }},
      {"flip", [&](const std::string& v) { device.flip = number_option("flip", v); }},
      {"lose", [&](const std::string& v) { device.lose = number_option("lose", v); }},
      {"late", [&](const std::string& v) { device.late = number_option("late", v); }},
      {"duplicate", [&](const std::string& v) { device.duplicate = number_option("duplicate", v); }},
      {"burst", [&](const std::string& v) { device.burst_s = number_option("burst", v); }},
      {"ppm", [&](const std::string& v) { device.clock_ppm = number_option("ppm", v); }},
      {"unplug", [&](const std::string& v) { device.unplug = span_option("unplug", v); }},
      {"silence", [&](const std::string& v) { device.silence = span_option("silence", v); }},
      {"slip", [&](const std::string& v) { device.slip = span_option("slip", v); }},
      {"slipshare", [&](const std::string& v) { device.slip_share = number_option("slipshare", v); }},
      {"restart", [&](const std::string& v) { device.restart_s = number_option("restart", v); }},
      {"reboot", [&](const std::string& v) { device.reboot_s = number_option("reboot", v); }},
      {"seed",
       [&](const std::string& v) {
         const double seed = number_option("seed", v);
         if (!(seed >= 0 && seed < 1e15)) throw InvalidInput("the seed of a simulator must be at least 0");
         device.seed = static_cast<std::uint64_t>(seed);
       }},
      {"size", [&](const std::string& v) { result.size_m = length_option(v); }},
      {"pace", [&](const std::string& v) { result.motion.pace = number_option("pace", v); }},
      {"rest", [&](const std::string& v) { result.motion.rest_s = number_option("rest", v); }},
      {"tumble", [&](const std::string& v) { result.motion.tumble = v != "0"; }},
      {"speed", [](const std::string&) {}}};  // of the clock: make_clock()
  for (const auto& [key, value] : options) {
    const auto option = known.find(key);
    if (option == known.end()) {
      std::string names;
      for (const auto& [name, set] : known) names += (names.empty() ? "" : ", ") + name;
      throw InvalidInput(concat("a simulator has no option '", key, "'; there are ", names));
    }
    option->second(value);
  }
  if (const auto problem = device.problem()) throw InvalidInput(*problem);
  if (const auto problem = result.motion.problem()) throw InvalidInput(*problem);
  return result;
}

SimulatedDevice simulated_device_of(const SourceSpec& spec) {
  SimulatorOptions options = simulator_options(spec.options);
  if (file_extension(spec.address) == "csv")
    return {DeviceMotion(read_sensor_log(spec.address), options.motion), options.device};
  const TracedNetwork traced = trace_shape(parse_choice<AnalyticShape>(spec.address));
  SimulateOptions simulate;
  simulate.step = kMotionStep;
  simulate.jitter = 0;
  const SensorLog log = simulate_log(traced, simulate_scan(traced, simulate), DeviceModel(), 0);
  options.motion.scale = options.size_m / traced.diameter;
  return {DeviceMotion(log, options.motion), options.device};
}

/// A simulated device with a simulated person at the keyboard.
class SimulatorSource : public Source {
 public:
  SimulatorSource(const SourceSpec& spec, HostClock& clock)
      : virtual_clock_(dynamic_cast<VirtualClock*>(&clock)),
        clock_(clock),
        device_(simulated_device_of(spec)) {
    const bool lines = device_.options().kind == SimulatedDeviceOptions::Kind::Line;
    if (virtual_clock_ == nullptr) terminal_ = std::make_unique<PseudoTerminal>(device_, clock);
    const StreamOpener open_stream = [this] {
      return terminal_ ? open_serial_port(terminal_->path(), kMorphoriderBaud, clock_)
                       : connect_directly(device_, *virtual_clock_);
    };
    inner_ = lines ? make_line_source(open_stream, clock, kLineSilence)
                   : make_morphorider_source(open_stream, clock);
  }

  void open() override { inner_->open(); }

  void poll(double seconds, std::vector<CaptureEvent>& events) override {
    const auto keys = terminal_ ? terminal_->keys() : device_.keys(clock_.now_us());
    for (const auto& [time, key] : keys) events.push_back({time, "keys", EventKind::Key, key});
    inner_->poll(seconds, events);
  }

  void close() override { inner_->close(); }

  SourceState state() const override {
    if (terminal_ ? terminal_->finished() : device_.finished(clock_.now_us()))
      return {SourceState::Kind::Ended, "the simulated motion is over"};
    return inner_->state();
  }

 private:
  VirtualClock* virtual_clock_;
  HostClock& clock_;
  SimulatedDevice device_;
  std::unique_ptr<PseudoTerminal> terminal_;
  std::unique_ptr<Source> inner_;
};

/// Takes a number behind the last `mark` off the text. @return nothing where there is none.
std::optional<int> take_number(std::string& text, char mark, const char* what, int most) {
  const std::size_t at = text.rfind(mark);
  if (at == std::string::npos) return std::nullopt;
  long number = 0;
  if (!parse_integer(text.substr(at + 1), number) || number < 1 || number > most)
    throw InvalidInput(
        concat("'", text.substr(at + 1), "' is no ", what, "; the forms of a source are ", kForms));
  text.resize(at);
  return static_cast<int>(number);
}

void read_address(SourceSpec& spec, std::string rest) {
  switch (spec.kind) {
    case SourceSpec::Kind::Morphorider:
      spec.number = take_number(rest, '@', "baud rate", 10000000).value_or(kMorphoriderBaud);
      break;
    case SourceSpec::Kind::Line:
      spec.number = take_number(rest, '@', "baud rate", 10000000).value_or(kLineBaud);
      break;
    case SourceSpec::Kind::WebSocket:
      while (!rest.empty() && rest.back() == '/') rest.pop_back();
      spec.number = take_number(rest, ':', "port", 65535).value_or(kWebSocketPort);
      if (rest.empty()) rest = kLoopback;
      break;
    case SourceSpec::Kind::Udp:
      if (rest.find(':') == std::string::npos) rest.insert(0, concat(kLoopback, ":"));
      spec.number = take_number(rest, ':', "port", 65535).value_or(0);
      break;
    default:
      break;
  }
  spec.address = rest;
  if (rest.empty())
    throw InvalidInput(concat("the source names no port, file or shape; the forms are ", kForms));
}

}  // namespace

SourceSpec parse_source(std::string_view text) {
  static const std::array<std::pair<const char*, SourceSpec::Kind>, 6> kKinds = {
      {{"morphorider:", SourceSpec::Kind::Morphorider},
       {"line:", SourceSpec::Kind::Line},
       {"ws://", SourceSpec::Kind::WebSocket},
       {"udp:", SourceSpec::Kind::Udp},
       {"file:", SourceSpec::Kind::File},
       {"simulator:", SourceSpec::Kind::Simulator}}};
  const auto* kind = std::find_if(kKinds.begin(), kKinds.end(), [text](const auto& entry) {
    return text.substr(0, std::string_view(entry.first).size()) == entry.first;
  });
  if (kind == kKinds.end()) throw InvalidInput(concat("'", text, "' is no source; the forms are ", kForms));
  SourceSpec spec;
  spec.kind = kind->second;
  std::string rest(text.substr(std::string_view(kind->first).size()));
  if (const std::size_t question = rest.find('?');
      question != std::string::npos && spec.kind != SourceSpec::Kind::File) {
    for (const std::string_view option : split_fields(std::string_view(rest).substr(question + 1), '&')) {
      if (option.empty()) continue;
      const std::size_t equals = std::min(option.find('='), option.size());
      spec.options[std::string(option.substr(0, equals))] =
          equals < option.size() ? std::string(option.substr(equals + 1)) : "1";
    }
    rest.resize(question);
  }
  read_address(spec, std::move(rest));
  return spec;
}

std::unique_ptr<HostClock> make_clock(const SourceSpec& spec) {
  const auto speed = spec.options.find("speed");
  if (speed == spec.options.end()) return std::make_unique<SteadyClock>();
  if (speed->second == "max") return std::make_unique<VirtualClock>();
  const double factor = number_option("speed", speed->second);
  if (!(factor > 0 && factor <= 1000))
    throw InvalidInput(
        concat("the speed of a source must be max, or above 0 and at most 1000, got ", speed->second));
  return std::make_unique<SteadyClock>(factor);
}

std::unique_ptr<Source> make_source(const SourceSpec& spec, HostClock& clock) {
  if (spec.kind == SourceSpec::Kind::Simulator) return std::make_unique<SimulatorSource>(spec, clock);
  for (const auto& [key, value] : spec.options)
    if (key != "speed" || spec.kind != SourceSpec::Kind::File)
      throw InvalidInput(concat("only simulators have options, got '", key, "'"));
  switch (spec.kind) {
    case SourceSpec::Kind::Morphorider:
      return make_morphorider_source(
          [spec, &clock] { return open_serial_port(spec.address, spec.number, clock); }, clock);
    case SourceSpec::Kind::Line:
      return make_line_source([spec, &clock] { return open_serial_port(spec.address, spec.number, clock); },
                              clock, kLineSilence);
    case SourceSpec::Kind::WebSocket:
      return make_line_source([spec, &clock] { return open_web_socket(spec.address, spec.number, clock); },
                              clock, 0);
    case SourceSpec::Kind::Udp:
      return make_line_source([spec, &clock] { return open_udp(spec.address, spec.number, clock); }, clock,
                              0);
    default:
      return make_replay_source(read_recording(spec.address), clock);
  }
}

std::vector<std::string> serial_ports() {
  std::vector<std::string> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
    const std::string name = entry.path().filename().string();
    for (const char* prefix : {"ttyUSB", "ttyACM", "rfcomm"})
      if (name.rfind(prefix, 0) == 0) found.push_back(entry.path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::pair<std::string, std::string>> list_sources() {
  std::vector<std::pair<std::string, std::string>> found;
  for (const std::string& port : serial_ports()) {
    found.emplace_back("line:" + port, "a device of the line protocol at a serial port");
    found.emplace_back("morphorider:" + port, "a Morphorider at a serial port");
  }
  found.emplace_back(concat("ws://", kLoopback, ":", kWebSocketPort),
                     "a page or program that connects to this port");
  found.emplace_back("udp:9000", "datagrams of lines to this port");
  for (const std::string& shape : choice_words<AnalyticShape>())
    found.emplace_back("simulator:" + shape, "simulated device");
  return found;
}

}  // namespace batten
